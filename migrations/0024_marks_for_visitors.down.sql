-- There is nothing to undo, because which sets were shared before is no longer known.
SELECT 1;
