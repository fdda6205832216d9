#include "api/environments/environments.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "api/shared/picture_file.h"
#include "api/shared/secrets.h"
#include "common/ids.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

using namespace std::chrono_literals;

tl::unexpected<Problem> no_such_environment() {
  return refuse(ProblemKind::kNotFound, "This environment no longer exists.");
}

tl::unexpected<Problem> environment_problem(const Error& error) {
  if (error.code == ErrorCode::kNotFound) return no_such_environment();
  return refuse(error);
}

tl::unexpected<Problem> too_many_environments() {
  return refuse(ProblemKind::kTooMany,
                "You have as many environments as an account can hold. Delete one first.");
}

}  // namespace

class Environments::Place {
 public:
  Place(Environments& of, const std::string& user) : of_(of), user_(user) {
    const std::lock_guard lock(of_.mutex_);
    mine_ = std::ranges::find(of_.importing_, user) != of_.importing_.end();
    taken_ = !mine_ && of_.importing_.size() < kMostImports;
    if (taken_) of_.importing_.push_back(user);
  }
  ~Place() {
    if (!taken_) return;
    const std::lock_guard lock(of_.mutex_);
    of_.importing_.erase(std::ranges::find(of_.importing_, user_));
  }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

  Outcome<void> taken() const {
    if (taken_) return {};
    if (mine_) {
      return refuse(ProblemKind::kTooMany, "Another of your environments is still being read.", 2s);
    }
    return refuse(ProblemKind::kBusy, "The server is busy. Try again in a moment.", 2s);
  }

 private:
  Environments& of_;
  const std::string user_;
  bool mine_ = false, taken_ = false;
};

Environments::Environments(EnvironmentStore& store, PanoramaImporter& importer, const Clock& clock,
                           const Signals& signals, const std::string& directory)
    : store_(store),
      importer_(importer),
      clock_(clock),
      signals_(signals),
      directory_(directory + "/environments") {}

Outcome<std::vector<Environment>> Environments::list(const Principal& who) {
  auto found = store_.of(who.user_id);
  if (!found) return refuse(found.error());
  for (Environment& one : *found) one.mine = true;
  return *std::move(found);
}

Outcome<Environment> Environments::find(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_environment();
  auto found = store_.find(id);
  if (!found) return environment_problem(found.error());
  found->mine = !who.user_id.empty() && found->owner_id == who.user_id;
  if (!found->mine) found->name.clear();
  return *std::move(found);
}

Outcome<ImportedPanorama> Environments::import(const Principal& who, const std::string& file) {
  const Place place(*this, who.user_id);
  DIAPHANE_TRY(place.taken());
  auto imported = importer_.import(file);
  if (imported) return *std::move(imported);
  if (imported.error().code != ErrorCode::kInvalid) return refuse(imported.error());
  // The field ends with a word that the page translates. It shows the sentence for an unknown word.
  return tl::unexpected(Problem{ProblemKind::kInvalid,
                                imported.error().message,
                                {{"file." + imported.error().field, imported.error().message}}});
}

Outcome<Environment> Environments::add(const Principal& who, const std::string& name,
                                       const std::string& file) {
  const std::string hash = blake2b(file);
  const auto mine = list(who);
  DIAPHANE_TRY(mine);
  const auto same = std::ranges::find(*mine, hash, &Environment::content_hash);
  if (same != mine->end()) return *same;
  // Checks the limit before the import, which takes seconds. store_.add checks it under a lock.
  if (mine->size() >= kMostEnvironments) return too_many_environments();
  const auto imported = import(who, file);
  DIAPHANE_TRY(imported);
  const Environment environment{new_id(),
                                who.user_id,
                                name,
                                hash,
                                imported->preview,
                                static_cast<std::int64_t>(imported->picture.size()),
                                clock_.wall(),
                                true};
  if (const auto written = write_picture(path_of(environment.id), imported->picture); !written) {
    return refuse(written.error());
  }
  const auto added = store_.add(environment, kMostEnvironments);
  if (added) return environment;
  // If the outcome is unknown, the row may exist and needs the file.
  if (added.error().code != ErrorCode::kOutcomeUnknown) (void)dispose(environment.id);
  if (added.error().code == ErrorCode::kTooMany) return too_many_environments();
  return refuse(added.error());
}

Outcome<Environment> Environments::rename(const Principal& who, const std::string& id,
                                          const std::string& name) {
  if (!is_id(id)) return no_such_environment();
  const auto renamed = store_.rename(who.user_id, id, name);
  if (!renamed) return environment_problem(renamed.error());
  return find(who, id);
}

Outcome<void> Environments::remove(const Principal& who, const std::string& id) {
  if (!is_id(id)) return no_such_environment();
  const auto removed = store_.remove(who.user_id, id);
  if (!removed) return environment_problem(removed.error());
  // At once, so that no scene still gets its light. The disposer repeats what fails.
  (void)dispose(id);
  signals_.raise(Signal::kDisposal);
  return {};
}

Result<void> Environments::dispose(const std::string& id) {
  std::error_code error;
  std::filesystem::remove(path_of(id), error);
  if (error) return fail(ErrorCode::kUnavailable, "cannot delete the environment");
  return {};
}

}  // namespace diaphane::api
