#pragma once

#include "directory/client.h"
#include "directory/constants.h"
#include "directory/placement.h"

namespace diaphane::directory {

/// Links to live sessions, stored next to their sessions as docs/contracts.md ("Redis") describes
/// (docs/adr/0013). Thread-safe.
class Links final : public LinkStore {
 public:
  struct Limits {
    std::uint32_t life_s = kLinkS;
    std::uint32_t per_session = 8;
  };
  explicit Links(Client& client) : Links(client, Limits()) {}
  Links(Client& client, Limits limits) : client_(client), limits_(limits) {}

  Result<void> make(std::string_view session_id, std::string_view user_id, std::string_view hash,
                    bool slices) override;
  Result<Target> follow(std::string_view hash) override;
  Result<void> end_links(std::string_view session_id) override;

 private:
  Client& client_;
  Limits limits_;
};

}  // namespace diaphane::directory
