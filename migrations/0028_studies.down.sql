DROP TABLE perception_comfort;
DROP TABLE study_pictures;
DROP TABLE study_recordings;
DROP TABLE study_answers;
DROP TABLE study_participants;
DROP TABLE studies;
ALTER TABLE users DROP COLUMN is_researcher;
