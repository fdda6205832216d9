#include "api/presets/presets.h"

#include <utility>

#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

tl::unexpected<Problem> no_such_preset() {
  return refuse(ProblemKind::kNotFound, "Preset not found.");
}

tl::unexpected<Problem> not_yours() {
  return refuse(ProblemKind::kForbidden,
                "This preset belongs to someone else. Save your own copy instead.");
}

tl::unexpected<Problem> from_store(const Error& error) {
  if (error.code == ErrorCode::kNotFound) return no_such_preset();
  if (error.code == ErrorCode::kConflict) {
    return refuse(ProblemKind::kPrecondition,
                  "This preset has changed in the meantime. Reload it before you edit it.");
  }
  return refuse(error);
}

bool refusal_is(const Outcome<DataSet>& outcome, ProblemKind kind) {
  return !outcome && outcome.error().kind == kind;
}

/// Only the author and administrators can see a preset that was taken down.
bool hidden(const Preset& preset, const Principal& who) {
  return preset.taken_down && !preset.mine && !who.administrator;
}

}  // namespace

Outcome<std::vector<Preset>> Presets::list(const Principal& who, const std::string& data_set_id) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kLook));
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
  if (auto visible = data_sets_.authorise(who, found->data_set_id, Action::kLook); !visible) {
    if (visible.error().kind == ProblemKind::kNotFound) return no_such_preset();
    return tl::unexpected(visible.error());
  }
  return *std::move(found);
}

Outcome<Preset> Presets::add(const Principal& who, const std::string& data_set_id, Preset preset,
                             const std::string& idempotency_key) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kSavePreset));
  preset.id = new_id();
  preset.data_set_id = data_set_id;
  preset.author_id = who.user_id;
  preset.created_at = clock_.wall();
  std::optional<IdempotencyKey> key;
  if (!idempotency_key.empty()) {
    key = IdempotencyKey{"createPreset", idempotency_key,
                         blake2b(data_set_id + "\n" + preset.name + "\n" + preset.scene + "\n" +
                                 preset.annotations + "\n" + preset.kept_xml)};
  }
  const auto made = store_.add(preset, key, {});
  if (!made) return from_store(made.error());
  if (std::holds_alternative<KeyReused>(*made)) {
    return refuse(ProblemKind::kIdempotencyKeyReused,
                  "This Idempotency-Key was already used with a different request.");
  }
  signals_.raise(Signal::kDisposal);
  signals_.raise(Signal::kPicture);
  auto found = find(who, std::get<Created>(*made).id);
  if (!found && found.error().kind == ProblemKind::kNotFound) {
    return refuse(ProblemKind::kConflict,
                  "The resource created with this Idempotency-Key has since been deleted.");
  }
  return found;
}

Outcome<Preset> Presets::change(const Principal& who, const std::string& id, int version,
                                const PresetChange& what) {
  const auto preset = find(who, id);
  if (!preset) return preset;
  if (!preset->mine) return not_yours();
  DIAPHANE_TRY(data_sets_.authorise(who, preset->data_set_id, Action::kSavePreset));
  const auto done = store_.change(id, version, what, clock_.wall());
  if (!done) return from_store(done.error());
  signals_.raise(Signal::kDisposal);
  signals_.raise(Signal::kPicture);
  return find(who, id);
}

Outcome<void> Presets::remove(const Principal& who, const std::string& id, int version) {
  const auto preset = find(who, id);
  DIAPHANE_TRY(preset);
  if (!preset->mine) {
    auto allowed = data_sets_.authorise(who, preset->data_set_id, Action::kDescribe);
    if (refusal_is(allowed, ProblemKind::kForbidden)) {
      allowed = data_sets_.authorise(who, preset->data_set_id, Action::kTakeDown);
    }
    if (refusal_is(allowed, ProblemKind::kForbidden)) return not_yours();
    DIAPHANE_TRY(allowed);
  }
  if (const auto done = store_.remove(id, version); !done) return from_store(done.error());
  signals_.raise(Signal::kDisposal);
  return {};
}

Outcome<Preset> Presets::vote(const Principal& who, const std::string& id, int value) {
  const auto preset = find(who, id);
  if (!preset) return preset;
  DIAPHANE_TRY(data_sets_.authorise(who, preset->data_set_id, Action::kVote));
  if (preset->taken_down)
    return refuse(ProblemKind::kForbidden, "This preset was removed by an administrator.");
  if (const auto done = store_.vote(id, who.user_id, value); !done) {
    return from_store(done.error());
  }
  return find(who, id);
}

Outcome<void> Presets::set_default(const Principal& who, const std::string& data_set_id,
                                   const std::string& preset_id) {
  DIAPHANE_TRY(data_sets_.authorise(who, data_set_id, Action::kDescribe));
  if (!preset_id.empty() && !is_id(preset_id)) return no_such_preset();
  const auto done = store_.set_default(data_set_id, preset_id);
  if (!done) return from_store(done.error());
  return {};
}

}  // namespace diaphane::api
