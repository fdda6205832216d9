#pragma once

#include <string>

#include "api/routing/request_fields.h"

namespace diaphane::api {

/// Parses a field with the message `Annotations` as Protobuf JSON, checks it and cleans its texts.
/// Returns the JSON to store.
std::string read_annotations(Fields& in, const std::string& field);

}  // namespace diaphane::api
