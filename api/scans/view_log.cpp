#include "api/scans/view_log.h"

#include "api/shared/secrets.h"

namespace diaphane::api {

std::string_view to_string(ViewRoute route) {
  for (const auto& [value, name] : kViewRoutes) {
    if (value == route) return name;
  }
  return "gallery";
}

ViewRoute view_route_of(std::string_view text) {
  for (const auto& [value, name] : kViewRoutes) {
    if (name == text) return value;
  }
  return ViewRoute::kGallery;
}

std::string viewer_hash(const std::string& viewer) { return blake2b("viewer:" + viewer); }

}  // namespace diaphane::api
