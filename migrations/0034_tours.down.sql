DROP TABLE data_set_tours;
