#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/redis/client.h"
#include "api/service/placement.h"
#include "api/service/render_time.h"
#include "api/service/workers.h"
#include "common/visitor_share.h"

namespace diaphane::api::redis {

/// Sessions, tickets and workers as docs/contracts.md ("Redis") keeps them. It holds no state of
/// its own: any number of `api` programs may share one Redis. Thread-safe.
class Sessions final : public Placement, public Tickets, public Workers, public SpentRenderTime {
 public:
  struct Limits {
    std::uint32_t placed = 8;       ///< sessions of one person that hold a slot
    std::uint32_t remembered = 64;  ///< sessions of one person in all
    std::uint32_t reservation_ms = 15'000;
    std::uint32_t ticket_s = 30;
    std::uint32_t session_s = 24 * 3600;
    /// So long a worker that had no memory for a session is not asked again.
    std::uint32_t refused_ms = 30'000;
    /// Of all slots, that people without an account may hold together (common/visitor_share.h).
    int visitor_percent = kVisitorPercent;
  };

  explicit Sessions(Client& client) : Sessions(client, Limits()) {}
  /// `fleet`: the RenderFleet that is to grow for who finds no place.
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
  /// `of`: "user" or "data_set".
  Result<std::vector<SessionInfo>> list(std::string_view of, std::string_view id);

  Client& client_;
  Limits limits_;
  std::string fleet_;
};

}  // namespace diaphane::api::redis
