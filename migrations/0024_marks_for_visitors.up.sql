-- So far, sets of marks were shared only with people who have an account. From this version, visitors with a link see
-- them, too. The owners have not agreed to that, so they have to share their sets again.
UPDATE annotations SET shared = false WHERE shared;
