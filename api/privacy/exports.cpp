#include "api/privacy/exports.h"

#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>

#include "common/ids.h"
#include "common/log.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

constexpr std::chrono::hours kSweepInterval{1};  // a sweep reads the IDs of all exports

constexpr std::string_view kReadMe =
    "This archive contains all the data that Diaphane stored about you when you requested it.\n\n"
    "records/   The database records, one JSON file per table. Passwords, cookies and the secret\n"
    "           parts of links are left out, because Diaphane stores them only as hashes.\n"
    "audit.json What was done to your account and your scans, and when.\n"
    "scans/     One folder per scan, named after the scan's ID. The titles that you gave your\n"
    "           scans are in records/data_sets.owner_id.json. volume.json holds the size of the\n"
    "           scan in voxels, the distance between voxels in millimetres and the orientation.\n"
    "           voxels.i16 holds the values as 16-bit little-endian integers; x varies fastest,\n"
    "           then y, then z. The values of a CT scan are in Hounsfield units. labels says\n"
    "           which voxels show the body, a part of it that the server found, such as bone, or\n"
    "           the table or the air around it. label_set holds the names and voxels of labels\n"
    "           that you added. marks.json holds the marks and measurements that you saved with\n"
    "           the scan, in millimetres from its centre. Those of other people's scans are in\n"
    "           records/annotations.author_id.json. presets/ holds one image of the scan per\n"
    "           preset.\n\n"
    "The files from your disc are not included, because Diaphane does not keep them.\n";

std::chrono::seconds pause_after(int waits) {
  constexpr int kMostDoublings = 10;
  return std::min<std::chrono::seconds>(
      Exports::kFirstPause * (1 << std::clamp(waits, 0, kMostDoublings)), Exports::kLongestPause);
}

tl::unexpected<Problem> none() {
  return refuse(ProblemKind::kNotFound, "There is no export. Request one first.");
}

}  // namespace

Exports::Exports(ExportStore& store, MakeFile make_file, const Clock& clock, const Signals& signals,
                 Options options)
    : store_(store),
      make_file_(std::move(make_file)),
      clock_(clock),
      signals_(signals),
      options_(std::move(options)) {}

Outcome<Export> Exports::request(const Principal& who) {
  const Time now = clock_.wall();
  const Export wanted{new_id(), Export::State::kQueued, 0, now, now + kLife};
  const auto made = store_.request(who.user_id, wanted, now - kPause);
  if (!made) return refuse(made.error());
  if (!*made) {
    return refuse(ProblemKind::kTooMany,
                  "You already have a recent export. You can request another one in ten minutes.",
                  kPause);
  }
  signals_.raise(Signal::kExport);
  return wanted;
}

Outcome<Export> Exports::find(const Principal& who) {
  const auto found = store_.find(who.user_id, clock_.wall());
  if (!found) return refuse(found.error());
  if (!*found) return none();
  return **found;
}

Outcome<void> Exports::remove(const Principal& who) {
  const auto done = store_.remove(who.user_id, clock_.wall());
  if (!done) return refuse(done.error());
  if (!*done) return none();
  signals_.raise(Signal::kDisposal);
  return {};
}

Outcome<std::string> Exports::file(const Principal& who) {
  const auto found = find(who);
  DIAPHANE_TRY(found);
  if (found->state != Export::State::kReady) {
    return refuse(ProblemKind::kNotReady, "The export is not ready yet.");
  }
  const auto noted = store_.note_download(who.user_id, who.client, clock_.wall());
  if (!noted) return refuse(noted.error());
  return found->id + ".zip";
}

Result<std::int64_t> Exports::write(const ExportStore::Job& job, const std::string& path) {
  auto file = make_file_(path);
  DIAPHANE_TRY(file);
  DIAPHANE_TRY((*file)->add("README.txt", kReadMe));
  const auto sections = store_.sections(job.user_id);
  DIAPHANE_TRY(sections);
  for (const ExportSection& section : *sections) {
    DIAPHANE_TRY((*file)->add(section.name, section.json));
  }
  const auto volumes = store_.volumes(job.user_id);
  DIAPHANE_TRY(volumes);
  // Skips data that was deleted in the meantime.
  const auto add = [&](const std::string& name, const std::string& source) -> Result<void> {
    auto done = (*file)->add_file(name, source);
    if (!done && done.error().code != ErrorCode::kNotFound) return done;
    return {};
  };
  for (const std::string& id : *volumes) {
    for (const char* name : {"volume.json", "voxels.i16", "labels", "label_set"}) {
      const std::string of_scan = id + "/" + name;
      DIAPHANE_TRY(add("scans/" + of_scan, options_.volumes + "/" + of_scan));
    }
  }
  const auto environments = store_.environments(job.user_id);
  DIAPHANE_TRY(environments);
  for (const std::string& id : *environments) {
    const std::string name = "environments/" + id + ".hdr";
    DIAPHANE_TRY(add(name, options_.volumes + "/" + name));
  }
  const auto pictures = store_.pictures(job.user_id);
  DIAPHANE_TRY(pictures);
  for (const ExportStore::Picture& one : *pictures) {
    const auto done = add("scans/" + one.data_set_id + "/presets/" + one.preset_id + ".jpg",
                          options_.pictures + "/" + one.preset_id + "/picture.jpg");
    DIAPHANE_TRY(done);
  }
  return (*file)->finish();
}

Result<void> Exports::check_room(const ExportStore::Job& job) const {
  const auto sizes = store_.sizes(job.user_id);
  DIAPHANE_TRY(sizes);
  struct statvfs info {};
  if (::statvfs(options_.exports.c_str(), &info) != 0) {
    return fail(ErrorCode::kUnavailable, "the export directory is unavailable");
  }
  const auto free =
      static_cast<std::int64_t>(info.f_bavail) * static_cast<std::int64_t>(info.f_frsize);
  if (free - options_.reserve_bytes < sizes->volumes) {
    return fail(ErrorCode::kUnavailable, "the disk is full");
  }
  if (sizes->kept > 0 && sizes->kept + sizes->volumes > options_.total_bytes) {
    return fail(ErrorCode::kUnavailable, "other exports use all the space reserved for exports");
  }
  return {};
}

Result<void> Exports::make(const ExportStore::Job& job) {
  std::error_code error;
  std::filesystem::create_directories(options_.exports, error);
  if (error) return fail(ErrorCode::kUnavailable, "the export directory is not writable");
  if (auto room = check_room(job); !room) return room;
  const std::string path = options_.exports + "/" + job.id + ".zip";
  const std::string unfinished = options_.exports + "/.tmp-" + job.id;
  const auto remove_files = [&] {
    std::filesystem::remove(unfinished, error);
    std::filesystem::remove(path, error);
  };
  const auto bytes = write(job, unfinished);
  if (bytes) std::filesystem::rename(unfinished, path, error);
  if (!bytes || error) {
    remove_files();
    DIAPHANE_TRY(bytes);
    return fail(ErrorCode::kUnavailable, "cannot rename the export");
  }
  const auto wanted = store_.finish(job.id, *bytes);
  // If the outcome is unknown, the export may be ready. If it is gone instead, sweep() deletes the
  // file.
  const bool unknown = !wanted && wanted.error().code == ErrorCode::kOutcomeUnknown;
  if (!unknown && !(wanted && *wanted)) remove_files();
  DIAPHANE_TRY(wanted);
  return {};
}

bool Exports::sweep() {
  namespace fs = std::filesystem;
  constexpr std::string_view kUnfinished = ".tmp-";
  std::vector<std::pair<std::string, fs::path>> files;  // with the ID of the export
  std::error_code error;
  for (fs::directory_iterator entry(options_.exports, error), end; !error && entry != end;
       entry.increment(error)) {
    std::string id = entry->path().filename();
    if (id.starts_with(kUnfinished)) {
      // That of a scan has a second ID behind it.
      id = id.substr(kUnfinished.size(), new_id().size());
    } else {
      // Exports of accounts, and those of scans, which ingestd writes.
      for (const std::string_view ending : {".zip", ".scan"}) {
        if (id.ends_with(ending)) id.resize(id.size() - ending.size());
      }
    }
    if (is_id(id)) files.emplace_back(std::move(id), entry->path());
  }
  if (files.empty()) return true;
  // The files are listed first, because an export exists before its file does.
  const auto ids = store_.ids();
  if (!ids) return false;
  for (const auto& [id, path] : files) {
    if (std::find(ids->begin(), ids->end(), id) == ids->end()) fs::remove(path, error);
  }
  return true;
}

void Exports::poll() {
  (void)store_.expire(clock_.wall());
  if (clock_.wall() >= next_sweep_ && sweep()) next_sweep_ = clock_.wall() + kSweepInterval;
  for (;;) {
    const auto job = store_.claim(clock_.wall(), kLease);
    if (!job || !*job) return;
    const ExportStore::Job& one = **job;
    const auto made = make(one);
    if (made) continue;
    log::warning("failed to create an export",
                 {{"export", one.id}, {"reason", made.error().message}, {"waits", one.waits + 1}});
    // An export that turns out to be ready does not return to the queue.
    if (made.error().code == ErrorCode::kUnavailable ||
        made.error().code == ErrorCode::kOutcomeUnknown) {
      (void)store_.wait(one.id, clock_.wall() + pause_after(one.waits));
    }
  }
}

}  // namespace diaphane::api
