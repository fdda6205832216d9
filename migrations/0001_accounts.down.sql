DROP TABLE idempotency_keys, mail_queue, sign_in_failures, web_sessions, email_tokens, users;
