#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/presets/presets.h"
#include "common/try.h"
#include "tests/support/api/fake.h"

namespace diaphane::api {

/// Presets in memory, for tests.
class FakePresetStore final : public PresetStore, public Fake {
 public:
  std::map<std::string, Preset> presets;                            ///< by ID
  std::map<std::string, std::pair<std::string, std::string>> keys;  ///< key to request hash and ID
  std::map<std::string, std::string> defaults;                      ///< by data set
  std::optional<PresetPicture> due;  ///< the next thumbnail to render
  std::chrono::seconds lease{0};     ///< of the last claim
  bool picture_is_wanted = true;     ///< false: the preset changed while it was rendered
  std::map<std::string, Time> postponed;
  std::vector<std::string> forgotten;

  Result<std::vector<Preset>> list(const std::string& data_set_id,
                                   const std::string& viewer_id) override {
    DIAPHANE_TRY(enter("list"));
    std::vector<Preset> found;
    for (const auto& [id, preset] : presets) {
      if (preset.data_set_id == data_set_id) found.push_back(seen_by(viewer_id, preset));
    }
    return found;
  }
  Result<Preset> find(const std::string& id, const std::string& viewer_id) override {
    DIAPHANE_TRY(enter("find"));
    const auto found = presets.find(id);
    if (found == presets.end()) return fail(ErrorCode::kNotFound, "no preset");
    return seen_by(viewer_id, found->second);
  }
  Result<std::variant<Created, KeyReused>> add(const Preset& preset,
                                               const std::optional<IdempotencyKey>& key,
                                               const Limits&) override {
    DIAPHANE_TRY(enter("add"));
    if (key && keys.contains(key->key)) {
      const auto& [hash, id] = keys[key->key];
      if (hash != key->request_hash) return KeyReused{};
      return Created{id, true};
    }
    presets[preset.id] = preset;
    if (key) keys[key->key] = {key->request_hash, preset.id};
    return Created{preset.id};
  }
  Result<void> change(const std::string& id, int version, const PresetChange& what,
                      Time now) override {
    DIAPHANE_TRY(enter("change"));
    Preset& preset = presets.at(id);
    if (preset.version != version) return fail(ErrorCode::kConflict, "another version");
    ++preset.version;
    preset.updated_at = now;
    preset.name = what.name.value_or(preset.name);
    return {};
  }
  Result<void> remove(const std::string& id, int version) override {
    DIAPHANE_TRY(enter("remove"));
    if (presets.at(id).version != version) return fail(ErrorCode::kConflict, "another version");
    presets.erase(id);
    return {};
  }
  Result<void> vote(const std::string& id, const std::string&, int value) override {
    DIAPHANE_TRY(enter("vote"));
    presets.at(id).my_vote = value;
    return {};
  }
  Result<void> set_default(const std::string& data_set_id, const std::string& id) override {
    DIAPHANE_TRY(enter("set_default"));
    if (!id.empty() && !presets.contains(id)) return fail(ErrorCode::kNotFound, "no preset");
    defaults[data_set_id] = id;
    return {};
  }
  Result<std::string> default_scene(const std::string&) override { return std::string(); }

  Result<std::optional<PresetPicture>> claim_picture(Time, std::chrono::seconds time) override {
    DIAPHANE_TRY(enter("claim_picture"));
    lease = time;
    return due;
  }
  Result<void> postpone_picture(const std::string& preset_id, Time again) override {
    DIAPHANE_TRY(enter("postpone_picture"));
    postponed[preset_id] = again;
    return {};
  }
  Result<bool> keep_picture(const PresetPicture& picture, Time now,
                            const std::function<Result<void>()>& write) override {
    DIAPHANE_TRY(enter("keep_picture"));
    if (!picture_is_wanted) return false;
    DIAPHANE_TRY(write());
    presets[picture.preset_id].pictured_at = now;
    return true;
  }
  Result<void> forget_picture(const std::string& preset_id) override {
    DIAPHANE_TRY(enter("forget_picture"));
    forgotten.push_back(preset_id);
    return {};
  }

 private:
  static Preset seen_by(const std::string& viewer_id, Preset preset) {
    preset.mine = preset.author_id == viewer_id;
    return preset;
  }
};

}  // namespace diaphane::api
