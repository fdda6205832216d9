DROP TABLE disposals, ingest_jobs, uploads, data_sets;
