#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/visitor_share.h"
#include "directory/client.h"
#include "directory/constants.h"
#include "directory/placement.h"
#include "directory/workers.h"

namespace diaphane::directory {

/// Sessions, tickets and workers, stored as docs/contracts.md ("Redis") describes. It has no state
/// of its own, so any number of `api` processes can share one Redis. Thread-safe.
class Sessions final : public Placement, public Tickets, public Workers, public SpentRenderTime {
 public:
  struct Limits {
    std::uint32_t placed = 8;       ///< maximum sessions with a slot per user
    std::uint32_t remembered = 64;  ///< maximum sessions per user in total
    std::uint32_t reservation_ms = 15'000;
    std::uint32_t ticket_s = 30;
    std::uint32_t session_s = kSessionS;
    /// Time for which a worker that had no memory for a session is not asked again.
    std::uint32_t refused_ms = 30'000;
    /// Percentage of all slots that people without an account may hold (common/visitor_share.h).
    int visitor_percent = kVisitorPercent;
  };

  explicit Sessions(Client& client) : Sessions(client, Limits()) {}
  /// `fleet` is the RenderFleet to scale up when no slot is free.
  Sessions(Client& client, Limits limits, std::string fleet = {})
      : client_(client), limits_(limits), fleet_(std::move(fleet)) {}

  Result<Placed> place(const PlaceRequest& request) override;
  Result<SessionInfo> find(std::string_view session_id) override;
  Result<std::vector<SessionInfo>> sessions_of(std::string_view user_id) override;
  Result<std::vector<SessionInfo>> sessions_on(std::string_view data_set_id) override;
  Result<void> end(std::string_view session_id) override;
  Result<void> end_all_of(std::string_view data_set_id) override;
  Result<void> end_all_by(std::string_view user_id) override;
  Result<void> end_all_from(std::string_view browser_id, std::string_view user_id) override;
  Result<void> refused(std::string_view session_id, std::string_view worker_id,
                       std::uint64_t placement) override;
  bool reachable() override;

  Result<Attachment> consume(std::string_view ticket) override;
  Result<std::vector<std::string>> ended_links(const std::vector<std::string>& links) override;

  Result<std::vector<WorkerInfo>> alive() override;
  Result<std::vector<std::pair<std::string, std::int64_t>>> take_render_time() override;
  Result<bool> lost(std::string_view worker_id, std::string_view incarnation) override;

 private:
  /// `of` is "user" or "data_set".
  Result<std::vector<SessionInfo>> list(std::string_view of, std::string_view id);

  Client& client_;
  Limits limits_;
  std::string fleet_;
};

}  // namespace diaphane::directory
