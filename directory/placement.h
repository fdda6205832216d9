#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

/// The sessions of the directory as seen by the REST API and the stream gateway. Implemented with
/// Redis (directory/sessions.h, links.h). docs/contracts.md, "Redis", describes the keys.
namespace diaphane::directory {

/// A session, which is stored only in Redis.
struct SessionInfo {
  std::string id;       ///< an ID as in common/ids.h
  std::string user_id;  ///< the user who opened it; it does not exist for anyone else
  std::string data_set_id;
  std::string worker_id;        ///< the worker of the last placement
  std::string charged_to = {};  ///< as in PlaceRequest
  std::string over = {};        ///< as in PlaceRequest
};

/// The relation of a viewer to the scan, from which the worker derives their permissions
/// (renderd/session/rights.h).
enum class SessionViewer {
  kGuest,          ///< joined with a link to the session; has the fewest permissions
  kOwner,          ///< the owner of the scan
  kShared,         ///< a user with whom the scan is shared
  kPublic,         ///< a user who views someone else's public scan
  kLinkVisitor,    ///< a visitor without an account who has a link to the scan
  kSampleVisitor,  ///< a visitor without an account who views a sample
};
/// Convert a viewer to and from "guest", "owner", "shared", "public", "link-visitor" or
/// "sample-visitor". Any other text means kGuest.
std::string_view to_string(SessionViewer viewer);
SessionViewer session_viewer_of(std::string_view text);

struct PlaceRequest {
  /// A new ID, or that of an existing session of this user, which is placed again if its worker is
  /// gone.
  std::string session_id;
  std::string user_id;
  std::string data_set_id;
  // Set for a guest's ticket and empty for the owner's.
  std::string participant = {};  ///< ID, the same after a reconnection
  std::string name = {};         ///< the name as typed
  std::string link = {};         ///< token hash of the link that they joined with
  /// The initial scene of a new session, a serialised diaphane.v1.Scene. Empty means the volume's
  /// default appearance.
  std::string first_scene = {};
  /// The requesting web session of the owner (WebSession::id). Empty for guests and visitors.
  std::string browser = {};
  SessionViewer viewer = SessionViewer::kGuest;  ///< the holder of the ticket
  /// Whether the owner of the scan allows the viewer exact slices. For a guest: whether their link
  /// allows all slices inside the clip at any time.
  bool slices = false;
  bool downloads = false;  ///< whether the owner of the scan allows videos and large pictures
  /// Whether the requester has no account and is placed only within the visitors' share of the
  /// slots.
  bool visitor = false;
  /// The source of a visitor, such as the hash of an address, for visitor_slots_of_source().
  std::string visitor_from = {};
  /// The account that pays for the session of a participant of a study: the session counts towards
  /// its limit and ends with it, but does not exist for it. Empty means the user themself.
  std::string charged_to = {};
  /// The data set that a new session shows over its own, or empty. It stays for the session's life.
  std::string over = {};
  /// The rigid motion from the coordinates of `over` to those of the session's data set: 16 numbers
  /// separated by spaces, or empty for the identity (api/proto/worker.proto, SecondScan).
  std::string to_first = {};
};

/// The current place of a session, and a new ticket for one connection to it.
struct Placed {
  std::string ticket;  ///< 64 hexadecimal digits, valid once and for 30 s
  std::string worker_id;
  std::uint64_t placement = 0;  ///< number of placements of this session
};

/// Chooses the worker of a session and stores its owner. Thread-safe. Every function returns
/// kUnavailable if Redis is unavailable and recovers automatically.
class Placement {
 public:
  virtual ~Placement() = default;
  /// Places a session in one round trip. Idempotent for a session with a live worker (only the
  /// ticket is new). Returns kUnavailable if no worker has a free slot or enough memory, kTooLarge
  /// if the visitors' share of the slots is in use (only for visitors), kNotFound if the ID belongs
  /// to another user's session, kTooMany if the user has reached the session limit, and
  /// kUnauthenticated if the browser has been signed out in the meantime.
  virtual Result<Placed> place(const PlaceRequest& request) = 0;
  /// Returns the session, or kNotFound if it does not exist.
  virtual Result<SessionInfo> find(std::string_view session_id) = 0;
  /// Returns the user's sessions, oldest first, without those that others opened at their expense.
  virtual Result<std::vector<SessionInfo>> sessions_of(std::string_view user_id) = 0;
  /// Returns all sessions on the data set, or that show it over another one, by any user.
  virtual Result<std::vector<SessionInfo>> sessions_on(std::string_view data_set_id) = 0;
  /// Deletes the session and frees its slot. A session that is already gone is not an error.
  virtual Result<void> end(std::string_view session_id) = 0;
  /// Ends all sessions that show a data set that is being deleted, by any user.
  virtual Result<void> end_all_of(std::string_view data_set_id) = 0;
  /// Ends all sessions that the user opened, and those that are charged to them.
  virtual Result<void> end_all_by(std::string_view user_id) = 0;
  /// Ends the user's sessions that the signed-out browser had a ticket for, and refuses further
  /// tickets for it.
  virtual Result<void> end_all_from(std::string_view browser_id, std::string_view user_id) = 0;
  /// Frees the slot of a worker that had no memory for the session. For a while, the session is
  /// placed only on other workers. Does nothing if the session has been placed again since.
  virtual Result<void> refused(std::string_view session_id, std::string_view worker_id,
                               std::uint64_t placement) = 0;
  /// Returns whether Redis answers within 100 ms, for /readyz.
  virtual bool reachable() = 0;
};

/// The data that the gateway needs to attach a browser to its worker.
struct Attachment {
  SessionInfo session;
  std::string address;      ///< host:port of the worker's gRPC server
  std::string incarnation;  ///< incarnation of the worker at the time of the placement
  std::uint64_t placement = 0;
  /// Last known scene, a serialised diaphane.v1.Scene; empty if there is none yet.
  std::string scene;
  std::uint64_t input_seq = 0;
  std::uint32_t width = 0, height = 0;  ///< last known viewport; 0 if there is none yet
  /// Participant ID of the last known presenter; empty for the owner.
  std::string presenter;
  std::string participant, name, link;  ///< set for a guest, as in PlaceRequest
  SessionViewer viewer = SessionViewer::kGuest;
  bool slices = false, downloads = false;  ///< as in PlaceRequest
  bool guest_slices = false;  ///< last known value: guests may get the slices that are shown
  bool visitor = false;       ///< the session belongs to the visitors' share of the slots
  std::string to_first;       ///< as in PlaceRequest
};

/// The gateway's side of a ticket. Thread-safe.
class Tickets {
 public:
  virtual ~Tickets() = default;
  /// Consumes the ticket, even if an error follows. Returns kUnauthenticated if the ticket is
  /// unknown, used or expired, kNotFound if its session has ended, or kUnavailable if its worker or
  /// Redis is gone.
  virtual Result<Attachment> consume(std::string_view ticket) = 0;
  /// Returns those of the links that were disabled. Viewers who joined with them must be
  /// disconnected.
  virtual Result<std::vector<std::string>> ended_links(const std::vector<std::string>& links) = 0;
};

/// Links for joining a session. A link is identified by the hash of its token. Thread-safe. Every
/// function returns kUnavailable if Redis is unavailable.
class LinkStore {
 public:
  virtual ~LinkStore() = default;
  struct Target {
    SessionInfo session;
    bool slices = false;  ///< guests with this link may get all slices inside the clip
  };
  /// Creates the link; an existing link stays unchanged. Returns kNotFound if the user has no such
  /// session, kConflict if the link was disabled, kInvalid if it exists with other `slices`, or
  /// kTooMany if the session has the maximum number of links.
  virtual Result<void> make(std::string_view session_id, std::string_view user_id,
                            std::string_view hash, bool slices) = 0;
  /// Returns the target of the link, or kNotFound.
  virtual Result<Target> follow(std::string_view hash) = 0;
  /// Disables all links of the session.
  virtual Result<void> end_links(std::string_view session_id) = 0;
};

}  // namespace diaphane::directory
