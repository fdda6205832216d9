#pragma once

#include "api/presets/presets.h"
#include "api/shared/database.h"

namespace diaphane::api {

/// Presets, their votes (migrations/0006), thumbnails (0008) and annotations (0022).
class PresetRepository final : public PresetStore {
 public:
  explicit PresetRepository(Database& database) : database_(database) {}

  Result<std::vector<Preset>> list(const std::string& data_set_id,
                                   const std::string& viewer_id) override;
  Result<Preset> find(const std::string& id, const std::string& viewer_id) override;
  Result<std::variant<Created, KeyReused>> add(const Preset& preset,
                                               const std::optional<IdempotencyKey>& key,
                                               const Limits& limits) override;
  Result<void> change(const std::string& id, int version, const PresetChange& what,
                      Time now) override;
  Result<void> remove(const std::string& id, int version) override;
  Result<void> vote(const std::string& id, const std::string& user_id, int value) override;
  Result<void> set_default(const std::string& data_set_id, const std::string& preset_id) override;
  Result<std::string> default_scene(const std::string& data_set_id) override;
  Result<std::optional<PresetPicture>> claim_picture(Time now, std::chrono::seconds lease) override;
  Result<void> postpone_picture(const std::string& preset_id, Time again) override;
  Result<bool> keep_picture(const PresetPicture& picture, Time now,
                            const std::function<Result<void>()>& write) override;
  Result<void> forget_picture(const std::string& preset_id) override;

 private:
  Database& database_;
};

}  // namespace diaphane::api
