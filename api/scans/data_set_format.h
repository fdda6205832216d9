#pragma once

#include <nlohmann/json.hpp>

#include "api/scans/data_set_store.h"

/// Converts a data set to the schema DataSet of api/openapi.yaml.
namespace diaphane::api {

nlohmann::ordered_json to_json(const DataSet& data_set);

}  // namespace diaphane::api
