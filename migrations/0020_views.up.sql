-- The log of who viewed a scan, for its owner: when, by which route and roughly from where. Unlike the audit log, it is
-- deleted with the scan. Views by one viewer within an hour are one row with a count. Rows are kept for 90 days.
CREATE TABLE views (
  id              uuid PRIMARY KEY,
  data_set_id     uuid NOT NULL REFERENCES data_sets ON DELETE CASCADE,
  route           text NOT NULL CHECK (route IN ('owner', 'person', 'gallery', 'administrator', 'link', 'live-link', 'export')),
  viewer_hash     text NOT NULL,                  -- identifies a returning viewer; BLAKE2b of the ID of an account, visit or participant
  email_key       text CHECK (length(email_key) BETWEEN 3 AND 254),  -- route 'person': the address that the owner entered
  link_created_at timestamptz,                    -- route 'link': creation of the link, which may be deleted since
  network         text NOT NULL CHECK (length(network) <= 19),       -- 16 bits of IPv4, 32 of IPv6; '' if unknown
  browser         text NOT NULL CHECK (length(browser) <= 60),       -- 'Firefox on Windows'
  first_at        timestamptz NOT NULL,
  last_at         timestamptz NOT NULL,
  times           int NOT NULL DEFAULT 1
);
CREATE INDEX views_data_set ON views (data_set_id, last_at DESC, id DESC);
CREATE INDEX views_viewer ON views (viewer_hash);
CREATE INDEX views_age ON views (last_at);
