#include "api/service/presets.h"

#include <utility>

#include "api/service/secrets.h"
#include "common/ids.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_preset() {
  return refuse(ProblemKind::kNotFound, "There is no such preset.");
}

tl::unexpected<Problem> not_yours() {
  return refuse(ProblemKind::kForbidden, "This preset is somebody else's. Save one of your own.");
}

tl::unexpected<Problem> from_store(const Error& error) {
  if (error.code == ErrorCode::kNotFound) return no_such_preset();
  if (error.code == ErrorCode::kConflict) {
    return refuse(ProblemKind::kPrecondition,
                  "This preset was changed meanwhile. Load it again before you change it.");
  }
  return refuse(error);
}

/// What was taken down is there for who made it and who judges it.
bool hidden(const Preset& preset, const Principal& who) {
  return preset.taken_down && !preset.mine && !who.administrator;
}

}  // namespace

Outcome<std::vector<Preset>> Presets::list(const Principal& who, const std::string& data_set_id) {
  if (auto seen = data_sets_.authorise(who, data_set_id, Action::kLook); !seen) {
    return tl::unexpected(seen.error());
  }
  auto found = store_.list(data_set_id, who.user_id);
  if (!found) return refuse(found.error());
  std::erase_if(*found, [&](const Preset& preset) { return hidden(preset, who); });
  return *std::move(found);
}

Outcome<Preset> Presets::find(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_preset();
  auto found = store_.find(id, who.user_id);
  if (!found) return from_store(found.error());
  if (hidden(*found, who)) return no_such_preset();
  if (auto seen = data_sets_.authorise(who, found->data_set_id, Action::kLook); !seen) {
    if (seen.error().kind == ProblemKind::kNotFound) return no_such_preset();
    return tl::unexpected(seen.error());
  }
  return *std::move(found);
}

Outcome<Preset> Presets::add(const Principal& who, const std::string& data_set_id, Preset preset,
                             const std::string& idempotency_key) {
  if (auto may = data_sets_.authorise(who, data_set_id, Action::kSavePreset); !may) {
    return tl::unexpected(may.error());
  }
  preset.id = new_id();
  preset.data_set_id = data_set_id;
  preset.author_id = who.user_id;
  preset.created_at = clock_.wall();
  std::optional<IdempotencyKey> key;
  if (!idempotency_key.empty()) {
    key = IdempotencyKey{
        "createPreset", idempotency_key,
        blake2b(data_set_id + "\n" + preset.name + "\n" + preset.scene + "\n" + preset.kept_xml)};
  }
  const auto made = store_.add(preset, key, {});
  if (!made) return from_store(made.error());
  if (std::holds_alternative<KeyReused>(*made)) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key came before with another request.");
  }
  wake_();
  auto found = find(who, std::get<Created>(*made).id);
  if (!found && found.error().kind == ProblemKind::kNotFound) {
    return refuse(ProblemKind::kConflict, "What this key made has been deleted since.");
  }
  return found;
}

Outcome<Preset> Presets::change(const Principal& who, const std::string& id, int version,
                                const PresetChange& what) {
  const auto preset = find(who, id);
  if (!preset) return preset;
  if (!preset->mine) return not_yours();
  if (auto may = data_sets_.authorise(who, preset->data_set_id, Action::kSavePreset); !may) {
    return tl::unexpected(may.error());
  }
  const auto done = store_.change(id, version, what, clock_.wall());
  if (!done) return from_store(done.error());
  wake_();
  return find(who, id);
}

Outcome<void> Presets::remove(const Principal& who, const std::string& id, int version) {
  const auto preset = find(who, id);
  if (!preset) return tl::unexpected(preset.error());
  const auto may = [&](Action action) {
    return data_sets_.authorise(who, preset->data_set_id, action).has_value();
  };
  if (!preset->mine && !may(Action::kDescribe) && !may(Action::kTakeDown)) return not_yours();
  if (const auto done = store_.remove(id, version); !done) return from_store(done.error());
  return {};
}

Outcome<Preset> Presets::vote(const Principal& who, const std::string& id, int value) {
  const auto preset = find(who, id);
  if (!preset) return preset;
  if (auto may = data_sets_.authorise(who, preset->data_set_id, Action::kVote); !may) {
    return tl::unexpected(may.error());
  }
  if (preset->taken_down) return refuse(ProblemKind::kForbidden, "This preset was taken down.");
  if (const auto done = store_.vote(id, who.user_id, value); !done) {
    return from_store(done.error());
  }
  return find(who, id);
}

Outcome<void> Presets::set_default(const Principal& who, const std::string& data_set_id,
                                   const std::string& preset_id) {
  if (auto may = data_sets_.authorise(who, data_set_id, Action::kDescribe); !may) {
    return tl::unexpected(may.error());
  }
  if (!preset_id.empty() && !is_id(preset_id)) return no_such_preset();
  const auto done = store_.set_default(data_set_id, preset_id);
  if (!done) return from_store(done.error());
  return {};
}

}  // namespace diaphane::api
