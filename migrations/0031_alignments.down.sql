DROP TRIGGER alignments_of_changed_scans ON data_sets;
DROP FUNCTION end_alignments;
DROP TABLE alignments;
