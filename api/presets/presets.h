#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/scans/data_sets.h"
#include "api/shared/idempotency.h"
#include "api/shared/signals.h"
#include "common/clock.h"

namespace diaphane::api {

struct Preset {
  std::string id, data_set_id;
  std::string author_id, author_name;  ///< the public name, or empty
  std::string name;
  int version = 1;  ///< increases with each change
  int votes = 0;    ///< votes for it minus votes against it
  int my_vote = 0;  ///< -1, 0, 1
  bool is_default = false;
  /// Whether it is the default and its author has changed the scene since the owner chose it.
  bool changed_since_default = false;
  bool mine = false;  ///< belongs to the requesting user
  /// Hidden by an administrator from everyone but its author and administrators.
  bool taken_down = false;
  std::string taken_down_reason;
  std::optional<Time> pictured_at;  ///< when its thumbnail was rendered; empty if there is none yet
  Time created_at, updated_at;
  std::string scene;        ///< Protobuf JSON of a checked Scene; empty in lists
  std::string annotations;  ///< Protobuf JSON of checked Annotations; empty if none or in lists
  std::string kept_xml;     ///< the source document, if it contains more than the scene
};

/// A change of a preset. Absent fields stay unchanged. Empty `annotations` remove the stored ones.
struct PresetChange {
  std::optional<std::string> name, scene, annotations;
};

/// A thumbnail to render. It is valid as long as the preset and the data set stay unchanged.
struct PresetPicture {
  std::string preset_id, data_set_id;
  std::string scene;           ///< Protobuf JSON
  std::optional<Time> cut_at;  ///< anonymised_at of the data set
};

/// Implemented by presets/preset_repository. Every function may return kUnavailable. Each is one
/// transaction. The caller checks permissions first (access.h).
class PresetStore {
 public:
  struct Limits {
    int of_author = 20;  ///< per data set
    int of_data_set = 500;
  };
  virtual ~PresetStore() = default;

  /// Returns the presets of a data set: the default first, then by votes, then oldest first.
  virtual Result<std::vector<Preset>> list(const std::string& data_set_id,
                                           const std::string& viewer_id) = 0;
  /// Returns a preset with its scene, or kNotFound if it does not exist.
  virtual Result<Preset> find(const std::string& id, const std::string& viewer_id) = 0;
  /// Adds a preset. Returns kTooMany if one of the limits is reached.
  virtual Result<std::variant<Created, KeyReused>> add(const Preset& preset,
                                                       const std::optional<IdempotencyKey>& key,
                                                       const Limits& limits) = 0;
  /// Returns kNotFound, or kConflict if the version has changed in the meantime.
  virtual Result<void> change(const std::string& id, int version, const PresetChange& what,
                              Time now) = 0;
  virtual Result<void> remove(const std::string& id, int version) = 0;
  /// Records the user's vote. A `value` of 0 withdraws it.
  virtual Result<void> vote(const std::string& id, const std::string& user_id, int value) = 0;
  /// An empty `preset_id` means none. Returns kNotFound for a preset of another data set.
  virtual Result<void> set_default(const std::string& data_set_id,
                                   const std::string& preset_id) = 0;
  /// Returns the scene of the default preset as Protobuf JSON, or an empty string.
  virtual Result<std::string> default_scene(const std::string& data_set_id) = 0;

  /// Claims the next thumbnail to render for a ready data set. No other caller gets it for `lease`,
  /// which doubles with each failure.
  virtual Result<std::optional<PresetPicture>> claim_picture(Time now,
                                                             std::chrono::seconds lease) = 0;
  /// Makes a thumbnail due again at `again` without a failure, because no worker was available.
  virtual Result<void> postpone_picture(const std::string& preset_id, Time again) = 0;
  /// Runs `write` (possibly twice) while the preset is locked, if it has not changed since
  /// rendering started. Otherwise returns false and writes nothing. Returns the errors of `write`.
  virtual Result<bool> keep_picture(const PresetPicture& picture, Time now,
                                    const std::function<Result<void>()>& write) = 0;
  /// Schedules a new rendering because the file is missing.
  virtual Result<void> forget_picture(const std::string& preset_id) = 0;
};

/// The presets of data sets. The caller validates their contents (presets/preset_format.h).
/// Thread-safe.
class Presets {
 public:
  Presets(DataSets& data_sets, PresetStore& store, const Clock& clock, const Signals& signals)
      : data_sets_(data_sets), store_(store), clock_(clock), signals_(signals) {}

  Outcome<std::vector<Preset>> list(const Principal& who, const std::string& data_set_id);
  Outcome<Preset> find(const Principal& who, const std::string& id);
  /// Saves the name, scene, annotations and kept_xml of `preset`. A repeated request with the same
  /// non-empty key creates no second preset. Returns kTooMany or kIdempotencyKeyReused.
  Outcome<Preset> add(const Principal& who, const std::string& data_set_id, Preset preset,
                      const std::string& idempotency_key);
  /// Requires the author. Returns kPrecondition if `version` is not the current one.
  Outcome<Preset> change(const Principal& who, const std::string& id, int version,
                         const PresetChange& what);
  /// Requires the author, the owner of the data set or an administrator.
  Outcome<void> remove(const Principal& who, const std::string& id, int version);
  Outcome<Preset> vote(const Principal& who, const std::string& id, int value);
  Outcome<void> set_default(const Principal& who, const std::string& data_set_id,
                            const std::string& preset_id);

 private:
  DataSets& data_sets_;
  PresetStore& store_;
  const Clock& clock_;
  const Signals& signals_;
};

}  // namespace diaphane::api
