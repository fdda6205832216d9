#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "api/routing/request_fields.h"
#include "api/studies/study.h"

/// The definition of a study as JSON (api/openapi.yaml, StudyDefinition).
namespace diaphane::api {

/// Maximum number of JSON values in a definition: one per 8 bytes of the largest body.
inline constexpr std::size_t kMostStudyValues = 131'072;

/// Reads the field `definition` of a request and reports errors.
StudyContent read_definition(Fields& in, Time now);

/// Returns the definition without what only the researcher may know: names of presets and the
/// comfort of pictures.
nlohmann::json definition_for_participants(const std::string& definition);

}  // namespace diaphane::api
