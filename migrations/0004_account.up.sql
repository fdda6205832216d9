-- Account changes, the administrator role, the audit log, rendering time, and exports.
ALTER TABLE users
  ADD COLUMN is_administrator boolean NOT NULL DEFAULT false,  -- set by `diaphane-api admin`
  ADD COLUMN disabled_at      timestamptz,                      -- by an administrator; the account can no longer sign in
  ADD COLUMN render_quota_ms  bigint NOT NULL DEFAULT 72000000 CHECK (render_quota_ms >= 0);  -- GPU time per month (UTC): 20 h

ALTER TABLE email_tokens DROP CONSTRAINT email_tokens_purpose_check;
ALTER TABLE email_tokens
  ADD COLUMN new_email text,  -- for purpose 'change': the address to confirm
  ADD CHECK (purpose IN ('verify', 'reset', 'change')),
  ADD CHECK ((purpose = 'change') = (new_email IS NOT NULL));

-- Lets users recognise a browser session: the time, and the approximate browser ("Firefox on Windows"). No IP address.
ALTER TABLE web_sessions
  ADD COLUMN id      uuid NOT NULL DEFAULT gen_random_uuid() UNIQUE,
  ADD COLUMN browser text NOT NULL DEFAULT '' CHECK (length(browser) <= 60),
  ADD COLUMN used_at timestamptz NOT NULL DEFAULT now();

-- The audit log. It contains only IDs and code words, no data of a scan and no address. Entries are kept for one year.
CREATE TABLE audit_log (
  id           bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  happened_at  timestamptz NOT NULL,
  actor        text NOT NULL CHECK (actor IN ('person', 'administrator', 'machine')),  -- 'machine': a command on the server
  actor_id     uuid,                                  -- NULL for the server or a deleted account
  action       text NOT NULL CHECK (action ~ '^[a-z]+(-[a-z]+)*(\.[a-z]+(-[a-z]+)*)+$'),
  subject      text NOT NULL CHECK (subject ~ '^[a-z_]{1,40}$'),  -- 'account', 'data_set', ...
  subject_id   uuid,
  details      jsonb NOT NULL DEFAULT '{}' CHECK (jsonb_typeof(details) = 'object' AND length(details::text) <= 2000)
);
CREATE INDEX audit_log_actor ON audit_log (actor_id, id);
CREATE INDEX audit_log_subject ON audit_log (subject_id, id);
CREATE INDEX audit_log_age ON audit_log (happened_at);

-- The audit log is append-only, except that the ID of a deleted account is cleared, and entries expire after a year.
CREATE FUNCTION audit_log_is_kept() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF TG_OP = 'DELETE' AND OLD.happened_at < now() - interval '365 days' THEN
    RETURN OLD;
  END IF;
  IF TG_OP = 'UPDATE'
     AND (NEW.id, NEW.happened_at, NEW.actor, NEW.action, NEW.subject, NEW.details)
         IS NOT DISTINCT FROM (OLD.id, OLD.happened_at, OLD.actor, OLD.action, OLD.subject, OLD.details)
     AND (NEW.actor_id IS NULL OR NEW.actor_id IS NOT DISTINCT FROM OLD.actor_id)
     AND (NEW.subject_id IS NULL OR NEW.subject_id IS NOT DISTINCT FROM OLD.subject_id) THEN
    RETURN NEW;
  END IF;
  RAISE EXCEPTION 'the audit log is only appended to';
END $$;
CREATE TRIGGER audit_log_rows BEFORE UPDATE OR DELETE ON audit_log FOR EACH ROW EXECUTE FUNCTION audit_log_is_kept();
CREATE TRIGGER audit_log_whole BEFORE TRUNCATE ON audit_log FOR EACH STATEMENT EXECUTE FUNCTION audit_log_is_kept();

-- GPU milliseconds used per account and month (first day of the month, UTC).
CREATE TABLE render_time (
  user_id      uuid NOT NULL REFERENCES users ON DELETE CASCADE,
  month        date NOT NULL CHECK (extract(day FROM month) = 1),
  device_ms    bigint NOT NULL DEFAULT 0 CHECK (device_ms >= 0),
  warned_at    timestamptz,  -- when the quota was used up; running sessions end some time later
  PRIMARY KEY (user_id, month)
);

-- Exports: all data stored about a user, as one Zip file in the cache directory. A job creates it. One per user.
CREATE TABLE exports (
  id            uuid PRIMARY KEY,               -- also the name of the file
  user_id       uuid NOT NULL UNIQUE REFERENCES users ON DELETE CASCADE,
  state         text NOT NULL CHECK (state IN ('queued', 'ready', 'failed')),
  bytes         bigint,
  attempts      int NOT NULL DEFAULT 0,
  leased_until  timestamptz,
  created_at    timestamptz NOT NULL,
  expires_at    timestamptz NOT NULL
);
CREATE INDEX exports_expiry ON exports (expires_at);

ALTER TABLE disposals DROP CONSTRAINT disposals_kind_check;
ALTER TABLE disposals ADD CHECK (kind IN ('upload', 'volume', 'export'));
