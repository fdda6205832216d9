-- Render sessions whose participant is gone: after a withdrawal, or with a preview, a study or an account. The background
-- task ends them, so that no session continues if Redis was unavailable at that moment.
CREATE TABLE study_ended_sessions (
  session_id  uuid PRIMARY KEY
);

CREATE FUNCTION participant_gone() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO study_ended_sessions (session_id) VALUES (OLD.session_id) ON CONFLICT DO NOTHING;
  RETURN NULL;
END $$;
CREATE TRIGGER participant_gone AFTER DELETE ON study_participants
  FOR EACH ROW WHEN (OLD.session_id IS NOT NULL) EXECUTE FUNCTION participant_gone();

-- Hashes of the random keys of participants who withdrew, so that a delayed repetition of their request to join adds
-- nobody. Nothing else is stored about them.
CREATE TABLE study_withdrawn_keys (
  key_hash  text PRIMARY KEY,
  study_id  uuid NOT NULL REFERENCES studies ON DELETE CASCADE
);
CREATE INDEX study_withdrawn_keys_study ON study_withdrawn_keys (study_id);
