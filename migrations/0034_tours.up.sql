-- The tour of a scan, through the views that the participants of a study chose. Moved along when the scan is cut.
CREATE TABLE data_set_tours (
  data_set_id  uuid PRIMARY KEY REFERENCES data_sets ON DELETE CASCADE,
  tour         text NOT NULL CHECK (octet_length(tour) <= 32768)   -- JSON, as GET /v1/data-sets/{data_set_id}/tour returns it
);
