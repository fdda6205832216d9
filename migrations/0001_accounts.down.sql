DROP TABLE idempotency_keys, mail_queue, attempts, web_sessions, email_tokens, users;
