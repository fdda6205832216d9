DELETE FROM api_tokens WHERE for_fetch OR scopes ~ 'archive';
ALTER TABLE api_tokens DROP CONSTRAINT api_tokens_scopes_check;
ALTER TABLE api_tokens ADD CONSTRAINT api_tokens_scopes_check
  CHECK (scopes ~ '^(read|write|share)( (read|write|share)){0,2}$');
ALTER TABLE api_tokens DROP COLUMN for_fetch;
ALTER TABLE users DROP COLUMN archive_access;
