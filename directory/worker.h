#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "directory/client.h"

namespace diaphane::directory {

/// The state that a worker reports every second. It expires after kHeartbeatMs.
struct Heartbeat {
  struct Session {
    std::string id;
    std::uint64_t placement = 0;
    bool visitor = false;  ///< a visitor's session, or a guest's free camera
  };
  std::string address;  ///< host:port of its gRPC server
  std::string engine, device;
  std::size_t slots = 0;
  bool draining = false;
  double load = 0;                   ///< share of the device used in the last second, 0 to 1
  double expected = 0;               ///< share of the device that its sessions are expected to need
  std::vector<std::string> volumes;  ///< IDs of the loaded volumes
  std::string node;                  ///< name of the machine that it runs on; empty: unknown
  std::vector<Session> sessions;     ///< its current sessions
};

struct HeartbeatReply {
  /// Address of another live worker with this name, in which case nothing was written.
  std::optional<std::string> name_taken_by;
  /// Sessions that were ended or placed on another worker. This worker must end them.
  std::vector<std::string> ended;
  /// Sessions that Redis has lost. This worker may restore them.
  std::vector<std::string> unknown;
};

/// The state that a worker of a fleet reports to the operator with its heartbeat.
struct FleetReport {
  std::string owner;
  double memory = 0;  ///< used share of the memory for loaded volumes, 0 to 1
  double error = 0;   ///< sum of the estimated relative errors of all its pictures
};

/// The state of a session that outlives its worker.
struct SavedScene {
  std::uint64_t placement = 0;
  std::string scene;  ///< a serialised diaphane.v1.Scene
  std::uint64_t input_seq = 0;
  std::uint32_t width = 0, height = 0;  ///< size of the viewport
  std::string presenter;                ///< participant ID; empty for the owner
  bool guest_slices = false;
};

/// A session that Redis has lost, as its worker knows it.
struct LostSession {
  std::string id, user_id, data_set_id;
  SavedScene saved;
  bool visitor = false;
  std::string over = {}, to_first = {};  ///< as in PlaceRequest
  /// Hashes of the guests' links, each followed by " slices" if the link allows all slices.
  std::vector<std::string> links;
};

/// Another worker, as of its last heartbeat.
struct Peer {
  std::string id, address;
  double load = 0;   ///< share of its device that its own sessions need
  double lent = 0;   ///< share used for other workers' sessions
  double age_s = 0;  ///< seconds since its heartbeat
  bool draining = false;
  std::vector<std::string> volumes;
  std::string node;  ///< as in Heartbeat
};

struct PeerQuery {
  double asked = 0;  ///< current demand of its own sessions, in devices
  /// Share of its device used for other workers' sessions. nullopt means that it lends nothing.
  std::optional<double> lent;
  std::string fleet;                 ///< fleet of the peers to return; empty: those without a fleet
  std::size_t random = 0;            ///< number of random workers to consider
  std::vector<std::string> helpers;  ///< IDs of workers to consider in any case
};

/// One worker's side of the session directory (docs/contracts.md, "Redis"). Errors are those of
/// Client. It has no state of its own. Thread-safe.
class WorkerDirectory {
 public:
  WorkerDirectory(Client& client, std::string worker_id, std::string incarnation)
      : client_(client), id_(std::move(worker_id)), incarnation_(std::move(incarnation)) {}

  /// Sends a heartbeat.
  Result<HeartbeatReply> beat(const Heartbeat& heartbeat);
  /// Removes the worker immediately, instead of waiting until its heartbeat expires.
  Result<void> leave();
  /// Reports to the operator. Returns nullopt, or the number of free slots on other workers if the
  /// operator wants this worker to drain.
  Result<std::optional<std::size_t>> report(const FleetReport& report);
  /// Adds rendering time, in milliseconds by user.
  Result<void> add_render_time(const std::map<std::string, std::uint64_t>& spent);
  /// Stores the state of a session. Returns false if it has ended or was placed again since.
  Result<bool> save_scene(const std::string& session_id, const SavedScene& saved);
  /// Restores a lost session. Returns false if Redis knows it, or if it was ended on purpose.
  Result<bool> restore(const LostSession& session);
  /// Reports the capacity that this worker lends, and returns live peers.
  Result<std::vector<Peer>> peers(const PeerQuery& query);

 private:
  Client& client_;
  const std::string id_, incarnation_;
};

}  // namespace diaphane::directory
