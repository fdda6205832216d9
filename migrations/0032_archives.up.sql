-- Access to the hospital's archives (PACS), which an administrator grants.
ALTER TABLE users ADD COLUMN archive_access boolean NOT NULL DEFAULT false;

-- The scope `archive`, and tokens with which the PACS gateway uploads what a user fetches. A token for a fetch lasts an
-- hour, can only upload, and is neither listed nor counted.
ALTER TABLE api_tokens ADD COLUMN for_fetch boolean NOT NULL DEFAULT false;
ALTER TABLE api_tokens DROP CONSTRAINT api_tokens_scopes_check;
ALTER TABLE api_tokens ADD CONSTRAINT api_tokens_scopes_check
  CHECK (scopes ~ '^(read|write|share|archive)( (read|write|share|archive)){0,3}$');
