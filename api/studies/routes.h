#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "api/routing/request_router.h"
#include "api/sharing/sharing.h"
#include "api/studies/participation.h"
#include "api/studies/studies.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

/// The languages in which people take part.
inline constexpr std::array<std::string_view, 2> kLanguages{"en", "de"};

std::vector<Route> study_routes(Studies& studies, Participations& participations,
                                const Clock& clock);
/// The answer to somebody who joined, or to a researcher who previews a study.
Response joined_response(const Participations::Joined& joined);

std::vector<Route> participant_routes(Participations& participations);

/// The tours of scans, which studies find.
std::vector<Route> tour_routes(Studies& studies, Visits& visits);

}  // namespace diaphane::api
