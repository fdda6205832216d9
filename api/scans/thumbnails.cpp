#include "api/scans/thumbnails.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <vector>

#include "api/shared/picture_file.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 8> kPresets{"skin",    "muscle", "vessels", "bone",
                                                   "through", "dense",  "airways", "brain"};
/// The end of each file name. Increase the number with every change of the looks in
/// renderd/scene/presets.cpp, so that no thumbnail shows a look that the scan no longer has.
constexpr std::string_view kSuffix = ".7.jpg";
/// Maximum number of requests that wait for a thumbnail of another request. Each holds a thread of
/// the API, like each rendering does.
constexpr int kMostWaiting = 2;

/// Deletes the thumbnails of earlier looks in the directory of one data set. Those that cannot be
/// deleted do no harm, and are deleted with the data set.
void remove_outdated(const fs::path& directory) {
  std::error_code error;
  fs::directory_iterator entry(directory, error);
  std::vector<fs::path> outdated;
  for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.ends_with(".jpg") && !name.ends_with(kSuffix)) outdated.push_back(entry->path());
  }
  for (const fs::path& path : outdated) fs::remove(path, error);
}

bool is_look(const std::string& preset) {
  return std::find(kPresets.begin(), kPresets.end(), preset) != kPresets.end();
}

tl::unexpected<Problem> no_such_look() {
  return refuse(ProblemKind::kNotFound, "Preset not found.");
}

}  // namespace

Thumbnails::Thumbnails(DataSets& data_sets, Stills& stills, std::string cache_directory, int slots,
                       std::chrono::milliseconds patience)
    : data_sets_(data_sets),
      stills_(stills),
      directory_(std::move(cache_directory)),
      slots_(static_cast<std::size_t>(slots)),
      patience_(patience) {}

Outcome<std::string> Thumbnails::get(const Principal& who, const std::string& data_set_id,
                                     const std::string& preset) {
  if (!is_look(preset)) return no_such_look();
  const auto find = [&] { return data_sets_.find_ready(who, data_set_id); };
  const auto data_set = find();
  DIAPHANE_TRY(data_set);
  DIAPHANE_TRY(data_sets_.note_picture(who, *data_set));
  return get(preset, *data_set, find);
}

Outcome<std::string> Thumbnails::get_with_link(const std::function<Outcome<Linked>()>& follow,
                                               const std::string& preset) {
  if (!is_look(preset)) return no_such_look();
  const auto linked = follow();
  DIAPHANE_TRY(linked);
  DIAPHANE_TRY(data_sets_.note_linked_picture(linked->data_set, linked->link_id));
  return get(preset, linked->data_set, [&]() -> Outcome<DataSet> {
    auto still = follow();
    DIAPHANE_TRY(still);
    return std::move(still->data_set);
  });
}

Outcome<std::string> Thumbnails::get(const std::string& preset, const DataSet& data_set,
                                     const std::function<Outcome<DataSet>()>& find) {
  const std::string path = "thumbnails/" + data_set.id + "/" + preset + std::string(kSuffix);

  {
    std::unique_lock lock(mutex_);
    // A thumbnail is rendered only once, and only a few requests wait for it.
    if (!wait_for_render(lock, path)) {
      return refuse(ProblemKind::kBusy,
                    "The preview is still being rendered. Please try again in a moment.",
                    std::chrono::seconds(1));
    }
    if (is_current(path, data_set.anonymised_at)) return path;
    if (rendering_.size() >= slots_) {
      return refuse(ProblemKind::kBusy,
                    "The server is rendering other previews. Please try again in a moment.",
                    std::chrono::seconds(1));
    }
    rendering_.insert(path);
  }
  auto rendered = [&]() -> Outcome<void> {
    try {
      return render(data_set.id, preset, path);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      rendering_.erase(path);
      done_.notify_all();
      throw;
    }
  }();
  {
    const std::lock_guard lock(mutex_);
    rendering_.erase(path);
  }
  done_.notify_all();
  DIAPHANE_TRY(rendered);

  // The data set may have been deleted or anonymised during the rendering, and its thumbnails may
  // have been deleted before this file existed.
  const auto still = find();
  if (!still || still->anonymised_at != data_set.anonymised_at) (void)remove(data_set.id);
  DIAPHANE_TRY(still);
  if (still->anonymised_at != data_set.anonymised_at) {
    return refuse(ProblemKind::kBusy, "The scan has changed in the meantime. Please try again.",
                  std::chrono::seconds(1));
  }
  return path;
}

bool Thumbnails::wait_for_render(std::unique_lock<std::mutex>& lock, const std::string& path) {
  if (!rendering_.contains(path)) return true;
  if (waiting_ >= kMostWaiting) return false;
  ++waiting_;
  const bool done = done_.wait_for(lock, patience_, [&] { return !rendering_.contains(path); });
  --waiting_;
  return done;
}

bool Thumbnails::is_current(const std::string& path, const std::optional<Time>& cut_at) const {
  std::error_code error;
  const auto written = fs::last_write_time(directory_ + "/" + path, error);
  if (error) return false;
  return !cut_at || std::chrono::file_clock::to_sys(written) > *cut_at;
}

Outcome<void> Thumbnails::render(const std::string& data_set_id, const std::string& preset,
                                 const std::string& path) {
  StillRequest request;
  request.data_set_id = data_set_id;
  request.preset = preset;
  const auto jpeg = stills_.render(request);
  if (!jpeg && jpeg.error().code == ErrorCode::kUnavailable) {
    return refuse(ProblemKind::kNoWorker, jpeg.error().message, std::chrono::seconds(2));
  }
  if (!jpeg) return refuse(jpeg.error());
  if (auto done = write_picture(directory_ + "/" + path, *jpeg); !done) return refuse(done.error());
  remove_outdated(fs::path(directory_ + "/" + path).parent_path());
  return {};
}

Result<void> Thumbnails::remove(const std::string& data_set_id) {
  std::error_code error;
  fs::remove_all(directory_ + "/thumbnails/" + data_set_id, error);
  if (error) return fail(ErrorCode::kUnavailable, "cannot delete the thumbnails");
  return {};
}

}  // namespace diaphane::api
