#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/shared/client.h"
#include "api/shared/cursor.h"
#include "api/shared/time.h"

/// The log of who viewed a scan, which its owner reads (migrations/0020). The audit log, which
/// administrators read, gets an entry in the same transaction (audit.h).
namespace diaphane::api {

/// How a viewer reached a scan.
enum class ViewRoute {
  kOwner,
  kPerson,  ///< the owner shared it with them
  kGallery,
  kAdministrator,
  kLink,
  kLiveLink,  ///< as a guest of a session
  kExport,    ///< in the owner's export of all their data
};
inline constexpr std::array<std::pair<ViewRoute, std::string_view>, 7> kViewRoutes{{
    {ViewRoute::kOwner, "owner"},
    {ViewRoute::kPerson, "person"},
    {ViewRoute::kGallery, "gallery"},
    {ViewRoute::kAdministrator, "administrator"},
    {ViewRoute::kLink, "link"},
    {ViewRoute::kLiveLink, "live-link"},
    {ViewRoute::kExport, "export"},
}};
std::string_view to_string(ViewRoute route);
ViewRoute view_route_of(std::string_view text);

/// Retention time of an entry after the last view that it counts.
inline constexpr std::chrono::hours kViewLife{24 * 90};
/// Maximum number of entries per scan and route. The limit per route prevents visitors from the
/// gallery from displacing the others.
inline constexpr int kMostViews = 200;
/// Views by a viewer within this time share an entry, so that reconnecting does not fill the log.
inline constexpr std::chrono::hours kSameView{1};

struct View {
  ViewRoute route = ViewRoute::kOwner;
  std::string viewer;        ///< ID of an account, a visit or a participant
  std::string link_id = {};  ///< ID of the link, for ViewRoute::kLink
  Client client;

  /// Returns whether `viewer` is an account.
  bool by_account() const { return route != ViewRoute::kLink && route != ViewRoute::kLiveLink; }
};

/// Returns the hash that identifies a viewer in the log without storing their ID.
std::string viewer_hash(const std::string& viewer);

/// One entry of the log, as the owner sees it.
struct ViewEntry {
  std::string id;
  ViewRoute route = ViewRoute::kOwner;
  std::string email_key;                ///< ViewRoute::kPerson: the address that the owner entered
  std::optional<Time> link_created_at;  ///< creation of the link, for ViewRoute::kLink
  std::string network;                  ///< coarse_network, or empty if unknown
  std::string browser;
  Time first_at, last_at;
  int times = 1;
};

struct ViewQuery {
  bool own = true;  ///< include the owner's own views and exports
  std::optional<Cursor> after;
  int limit = 0;
};

struct ViewPage {
  std::vector<ViewEntry> items;
  std::optional<Cursor> next;
};

}  // namespace diaphane::api
