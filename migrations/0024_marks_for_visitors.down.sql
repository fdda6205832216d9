-- Nothing to undo: what was shared before is no longer known.
SELECT 1;
