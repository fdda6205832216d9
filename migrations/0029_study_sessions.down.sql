DROP TABLE study_withdrawn_keys;
DROP TRIGGER participant_gone ON study_participants;
DROP FUNCTION participant_gone;
DROP TABLE study_ended_sessions;
