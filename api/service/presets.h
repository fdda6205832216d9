#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/service/data_sets.h"
#include "api/service/idempotency.h"
#include "common/clock.h"

namespace diaphane::api {

struct Preset {
  std::string id, data_set_id;
  std::string author_id, author_name;  ///< the name is the public one, or empty
  std::string name;
  int version = 1;  ///< rises with each change
  int votes = 0;    ///< for it less against it
  int my_vote = 0;  ///< -1, 0, 1
  bool is_default = false;
  /// The default, and its author has changed the scene since the owner chose it.
  bool changed_since_default = false;
  bool mine = false;        ///< of the one who asked
  bool taken_down = false;  ///< by an administrator: there for its author and administrators alone
  std::string taken_down_reason;
  std::optional<Time> pictured_at;  ///< when its picture was made; none: there is none yet
  Time created_at, updated_at;
  std::string scene;     ///< Protobuf JSON of a checked Scene; empty in lists
  std::string kept_xml;  ///< the document it was read from, when it holds more than the scene
};

/// Absent: stays.
struct PresetChange {
  std::optional<std::string> name, scene;
};

/// A picture to be made: of this scene, as long as preset and data set stay what they are.
struct PresetPicture {
  std::string preset_id, data_set_id;
  std::string scene;           ///< Protobuf JSON
  std::optional<Time> cut_at;  ///< anonymised_at of the data set
};

/// Implemented by postgres/preset_repository. Every function: kUnavailable. Each is one
/// transaction. Whether somebody may is asked before (access.h).
class PresetStore {
 public:
  struct Limits {
    int of_author = 20;  ///< in one data set
    int of_data_set = 500;
  };
  virtual ~PresetStore() = default;

  /// The default first, then by votes, then the oldest first.
  virtual Result<std::vector<Preset>> list(const std::string& data_set_id,
                                           const std::string& viewer_id) = 0;
  /// kNotFound.
  virtual Result<Preset> find(const std::string& id, const std::string& viewer_id) = 0;
  /// kTooMany.
  virtual Result<std::variant<Created, KeyReused>> add(const Preset& preset,
                                                       const std::optional<IdempotencyKey>& key,
                                                       const Limits& limits) = 0;
  /// kNotFound; kConflict when it is of another version by now.
  virtual Result<void> change(const std::string& id, int version, const PresetChange& what,
                              Time now) = 0;
  virtual Result<void> remove(const std::string& id, int version) = 0;
  /// `value` 0 takes it back.
  virtual Result<void> vote(const std::string& id, const std::string& user_id, int value) = 0;
  /// `preset_id` empty: none. kNotFound unless it is one of that data set.
  virtual Result<void> set_default(const std::string& data_set_id,
                                   const std::string& preset_id) = 0;
  /// Protobuf JSON of the default preset's scene; empty: there is none.
  virtual Result<std::string> default_scene(const std::string& data_set_id) = 0;

  /// The next picture to be made, of a data set that is ready; nobody else is given it before
  /// `lease` is over, and longer each time that it fails.
  virtual Result<std::optional<PresetPicture>> claim_picture(Time now,
                                                             std::chrono::seconds lease) = 0;
  /// Nobody could be asked for it: to be tried again at `again`, as if it had not been.
  virtual Result<void> postpone_picture(const std::string& preset_id, Time again) = 0;
  /// Carries out `write` (maybe twice) while the preset stands still, if it is what it was when the
  /// picture was begun; false when it is not, and nothing is written. What goes wrong in `write` is
  /// given back.
  virtual Result<bool> keep_picture(const PresetPicture& picture, Time now,
                                    const std::function<Result<void>()>& write) = 0;
  /// Its file is not there (any more): it is made anew.
  virtual Result<void> forget_picture(const std::string& preset_id) = 0;
};

/// Presets of data sets. A scene is checked before it comes here (handlers/preset_format.h).
/// Thread-safe.
class Presets {
 public:
  Presets(DataSets& data_sets, PresetStore& store, const Clock& clock)
      : data_sets_(data_sets), store_(store), clock_(clock) {}

  Outcome<std::vector<Preset>> list(const Principal& who, const std::string& data_set_id);
  Outcome<Preset> find(const Principal& who, const std::string& id);
  /// `preset`: name, scene, kept_xml. The same key makes it once; empty: none. kTooMany,
  /// kIdempotencyKeyReused.
  Outcome<Preset> add(const Principal& who, const std::string& data_set_id, Preset preset,
                      const std::string& idempotency_key);
  /// By its author. kPrecondition: `version` is not what it is now.
  Outcome<Preset> change(const Principal& who, const std::string& id, int version,
                         const PresetChange& what);
  /// By its author, the owner of the data set, or an administrator.
  Outcome<void> remove(const Principal& who, const std::string& id, int version);
  Outcome<Preset> vote(const Principal& who, const std::string& id, int value);
  Outcome<void> set_default(const Principal& who, const std::string& data_set_id,
                            const std::string& preset_id);

  /// Called when there may be a picture to be made.
  void on_picture(std::function<void()> wake) { wake_ = std::move(wake); }

 private:
  DataSets& data_sets_;
  PresetStore& store_;
  const Clock& clock_;
  std::function<void()> wake_ = [] {};
};

}  // namespace diaphane::api
