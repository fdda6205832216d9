#pragma once

#include <vector>

#include "api/annotations/annotations.h"
#include "api/routing/request_router.h"
#include "api/sharing/sharing.h"

/// The operations of api/openapi.yaml for this feature. Arguments passed by reference must outlive
/// the routes.
namespace diaphane::api {

std::vector<Route> annotation_routes(AnnotationSets& sets, Visits& visits);

}  // namespace diaphane::api
