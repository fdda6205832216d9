#include "directory/placement.h"

#include <array>
#include <utility>

namespace diaphane::directory {
namespace {

constexpr std::array<std::pair<SessionViewer, std::string_view>, 6> kNames{{
    {SessionViewer::kGuest, "guest"},
    {SessionViewer::kOwner, "owner"},
    {SessionViewer::kShared, "shared"},
    {SessionViewer::kPublic, "public"},
    {SessionViewer::kLinkVisitor, "link-visitor"},
    {SessionViewer::kSampleVisitor, "sample-visitor"},
}};

}  // namespace

std::string_view to_string(SessionViewer viewer) {
  for (const auto& [value, name] : kNames) {
    if (value == viewer) return name;
  }
  return "guest";
}

SessionViewer session_viewer_of(std::string_view text) {
  for (const auto& [value, name] : kNames) {
    if (name == text) return value;
  }
  return SessionViewer::kGuest;
}

}  // namespace diaphane::directory
