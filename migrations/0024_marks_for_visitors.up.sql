-- Sets of marks were shared with people who have an account. Now visitors with a link see them too, which their owners
-- have not agreed to, so that each owner has to share them again.
UPDATE annotations SET shared = false WHERE shared;
