#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"

/// What the REST side and the stream gateway need of the render workers. Implemented over Redis
/// (api/redis) and gRPC (api/stream); docs/contracts.md, "Redis" and "Stream", has the keys.
namespace diaphane::api {

/// A session as it is kept in Redis. Nothing of it is kept elsewhere.
struct SessionInfo {
  std::string id;       ///< common/ids.h form
  std::string user_id;  ///< who opened it; to anybody else it does not exist
  std::string data_set_id;
  std::string worker_id;  ///< where it was placed last
};

/// What somebody who opens or joins a session is to its scan: the worker gives them rights by it
/// (renderd/session/rights.h).
enum class SessionViewer {
  kGuest,          ///< by a link into the session; has the least rights
  kOwner,          ///< of the scan
  kShared,         ///< an account that the scan is shared with
  kPublic,         ///< an account that looks at a public scan of somebody else
  kLinkVisitor,    ///< without an account, by a link to the scan
  kSampleVisitor,  ///< without an account, at a sample
};
/// "guest", "owner", "shared", "public", "link-visitor", "sample-visitor"; of any other text
/// kGuest.
std::string_view to_string(SessionViewer viewer);
SessionViewer session_viewer_of(std::string_view text);

struct PlaceRequest {
  std::string
      session_id;  ///< new, or one of this user's: then it is placed again if its worker has gone
  std::string user_id;
  std::string data_set_id;
  // The ticket is a guest's; empty of the owner's.
  std::string participant = {};  ///< id, the same over reconnections
  std::string name = {};         ///< as typed
  std::string link = {};         ///< hash of the token of the link that let him in
  /// Of a session that is new: what it shows first, a serialised diaphane.v1.Scene; empty: the
  /// volume's own look.
  std::string first_scene = {};
  /// The owner's sign-in that asks (WebSession::id); empty of guests and visitors.
  std::string browser = {};
  SessionViewer viewer = SessionViewer::kGuest;  ///< the ticket's holder
  /// Of kPublic and of visitors: the scan's owner lets them have exact slices.
  bool slices = false;
  /// Somebody without an account asks: placed within the visitors' share of the slots alone.
  bool visitor = false;
  /// Of a visitor: who counts as one when half of that share is taken, for example the hash of an
  /// address.
  std::string visitor_from = {};
};

/// Where the session is now and a fresh ticket for one connection to it.
struct Placed {
  std::string ticket;  ///< 64 hexadecimal digits, single use, lives 30 s
  std::string worker_id;
  std::uint64_t placement = 0;  ///< counts the placings of this session
};

/// Chooses the worker of a session and remembers whose session it is. Thread-safe.
/// Every function: kUnavailable when Redis is away (recovers by itself).
class Placement {
 public:
  virtual ~Placement() = default;
  /// One round trip. Idempotent for a session whose worker lives (only the ticket is new).
  /// kUnavailable: no worker with a free slot, or none with the memory. kTooLarge: the visitors'
  /// share of the slots is taken (of a visitor alone). kNotFound: the id is a
  /// session of another user. kTooMany: the user has as many sessions as one may have.
  /// kUnauthenticated: the browser was signed out meanwhile.
  virtual Result<Placed> place(const PlaceRequest& request) = 0;
  /// kNotFound when there is none.
  virtual Result<SessionInfo> find(std::string_view session_id) = 0;
  /// The user's sessions, oldest first.
  virtual Result<std::vector<SessionInfo>> sessions_of(std::string_view user_id) = 0;
  /// Those that look at the data set, whoever opened them.
  virtual Result<std::vector<SessionInfo>> sessions_on(std::string_view data_set_id) = 0;
  /// Forgets the session and gives its slot back. Ending what has gone already is no error.
  virtual Result<void> end(std::string_view session_id) = 0;
  /// Ends every session that looks at the data set, whoever opened it: it is being deleted.
  virtual Result<void> end_all_of(std::string_view data_set_id) = 0;
  /// Ends every session that the user opened.
  virtual Result<void> end_all_by(std::string_view user_id) = 0;
  /// Ends every session of the user that the browser was given a ticket for, and gives it no
  /// further ticket: it was signed out.
  virtual Result<void> end_all_from(std::string_view browser_id, std::string_view user_id) = 0;
  /// The worker had no memory for the session as it was placed there: its slot is given back, and
  /// for a while the session is placed on others. Nothing when it was placed anew since.
  virtual Result<void> refused(std::string_view session_id, std::string_view worker_id,
                               std::uint64_t placement) = 0;
  /// Within 100 ms: for /readyz.
  virtual bool reachable() = 0;
};

/// What the gateway needs to attach a browser to its worker.
struct Attachment {
  SessionInfo session;
  std::string address;      ///< host:port of the worker's gRPC
  std::string incarnation;  ///< of the worker when it was placed
  std::uint64_t placement = 0;
  std::string scene;  ///< last known scene, serialised diaphane.v1.Scene; empty: none yet
  std::uint64_t input_seq = 0;
  std::uint32_t width = 0, height = 0;  ///< last known viewport; 0: none yet
  std::string presenter;                ///< last known, participant; empty: the owner
  std::string participant, name, link;  ///< of a guest, as in PlaceRequest
  SessionViewer viewer = SessionViewer::kGuest;
  bool slices = false;
  bool guest_slices = false;  ///< last known: the session's guests may have exact slices
  bool visitor = false;       ///< the session belongs to the visitors' share of the slots
};

/// The gateway's side of a ticket. Thread-safe.
class Tickets {
 public:
  virtual ~Tickets() = default;
  /// Uses the ticket up, also when what follows fails. kUnauthenticated: unknown, used or too old.
  /// kNotFound: its session has gone. kUnavailable: its worker, or Redis, has gone.
  virtual Result<Attachment> consume(std::string_view ticket) = 0;
  /// Those of these links that were ended: who came by them is to be sent away.
  virtual Result<std::vector<std::string>> ended_links(const std::vector<std::string>& links) = 0;
};

/// Links by which others join a session. A link is known by the hash of its token. Thread-safe.
/// Every function: kUnavailable when Redis is away.
class LinkStore {
 public:
  virtual ~LinkStore() = default;
  /// One that is there stays. kNotFound: no such session of this user. kConflict: it was ended.
  /// kTooMany: the session has as many as it may have.
  virtual Result<void> make(std::string_view session_id, std::string_view user_id,
                            std::string_view hash) = 0;
  /// The session that a link leads to; kNotFound.
  virtual Result<SessionInfo> follow(std::string_view hash) = 0;
  /// All of a session.
  virtual Result<void> end_links(std::string_view session_id) = 0;
};

struct StillRequest {
  std::string data_set_id;
  std::string preset;      ///< "skin", "muscle", "vessels", "bone", "airways"; or
  std::string scene = {};  ///< a serialised diaphane.v1.Scene
  std::uint32_t width = 320, height = 320;
  std::uint32_t samples = 64;  ///< per pixel, at most
  double error = 0;            ///< estimated, at which it is good enough; 0: all samples
  bool background = false;     ///< nobody waits: others go first
};

/// Pictures without a session: thumbnails. Thread-safe; blocks up to 20 s, in the background 60 s.
class Stills {
 public:
  virtual ~Stills() = default;
  /// JPEG bytes. kUnavailable: no worker answers. kNotFound: the worker has no such volume.
  virtual Result<std::string> render(const StillRequest& request) = 0;
};

}  // namespace diaphane::api
