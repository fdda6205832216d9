#include "api/service/exports.h"

#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>

#include "common/ids.h"
#include "common/log.h"

namespace diaphane::api {
namespace {

constexpr std::string_view kReadMe =
    "Everything that Diaphane holds of you, as of the moment when you asked for it.\n\n"
    "records/   What the database says, a file for each table; JSON. Passwords, cookies and the\n"
    "           secrets of links are kept as hashes only and are left out.\n"
    "audit.json What was done to your account and your scans, and when.\n"
    "scans/     A folder for each scan, named by its id (records/data_sets.owner_id.json has the\n"
    "           title that you gave it). volume.json says its size in voxels, the distance of\n"
    "           voxels in mm, and its orientation. voxels.i16 are the values: 16-bit whole\n"
    "           numbers, little endian, x fastest, then y, then z; of a CT in Hounsfield units.\n"
    "           presets/ are pictures of the scan, one for each preset saved for it.\n\n"
    "The files from your disc are not here, because they are not kept.\n";

std::chrono::seconds pause_after(int waits) {
  constexpr int kMostDoublings = 10;
  return std::min<std::chrono::seconds>(
      Exports::kFirstPause * (1 << std::clamp(waits, 0, kMostDoublings)), Exports::kLongestPause);
}

tl::unexpected<Problem> none() {
  return refuse(ProblemKind::kNotFound, "There is no export; ask for one.");
}

}  // namespace

Exports::Exports(ExportStore& store, MakeFile make_file, const Clock& clock, Options options)
    : store_(store),
      make_file_(std::move(make_file)),
      clock_(clock),
      options_(std::move(options)) {}

Outcome<Export> Exports::request(const Principal& who) {
  const Time now = clock_.wall();
  const Export wanted{new_id(), Export::State::kQueued, 0, now, now + kLife};
  const auto made = store_.request(who.user_id, wanted, now - kPause);
  if (!made) return refuse(made.error());
  if (!*made) {
    return refuse(ProblemKind::kTooMany,
                  "There is a fresh export already. Ask again in ten minutes.", kPause);
  }
  wake_();
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
  return {};
}

Outcome<std::string> Exports::file(const Principal& who) {
  const auto found = find(who);
  if (!found) return tl::unexpected(found.error());
  if (found->state != Export::State::kReady) {
    return refuse(ProblemKind::kNotReady, "The export is not ready.");
  }
  return found->id + ".zip";
}

Result<std::int64_t> Exports::write(const ExportStore::Job& job, const std::string& path) {
  auto file = make_file_(path);
  if (!file) return tl::unexpected(file.error());
  if (auto done = (*file)->add("README.txt", kReadMe); !done) return tl::unexpected(done.error());
  const auto sections = store_.sections(job.user_id);
  if (!sections) return tl::unexpected(sections.error());
  for (const ExportSection& section : *sections) {
    if (auto done = (*file)->add(section.name, section.json); !done) {
      return tl::unexpected(done.error());
    }
  }
  const auto volumes = store_.volumes(job.user_id);
  if (!volumes) return tl::unexpected(volumes.error());
  // What was deleted since is not held any more.
  const auto add = [&](const std::string& name, const std::string& source) -> Result<void> {
    auto done = (*file)->add_file(name, source);
    if (!done && done.error().code != ErrorCode::kNotFound) return done;
    return {};
  };
  for (const std::string& id : *volumes) {
    for (const char* name : {"volume.json", "voxels.i16"}) {
      const std::string of_scan = id + "/" + name;
      if (auto done = add("scans/" + of_scan, options_.volumes + "/" + of_scan); !done) {
        return tl::unexpected(done.error());
      }
    }
  }
  const auto pictures = store_.pictures(job.user_id);
  if (!pictures) return tl::unexpected(pictures.error());
  for (const ExportStore::Picture& one : *pictures) {
    const auto done = add("scans/" + one.data_set_id + "/presets/" + one.preset_id + ".jpg",
                          options_.pictures + "/" + one.preset_id + "/picture.jpg");
    if (!done) return tl::unexpected(done.error());
  }
  return (*file)->finish();
}

Result<void> Exports::check_room(const ExportStore::Job& job) const {
  const auto sizes = store_.sizes(job.user_id);
  if (!sizes) return tl::unexpected(sizes.error());
  struct statvfs info {};
  if (::statvfs(options_.exports.c_str(), &info) != 0) {
    return fail(ErrorCode::kUnavailable, "the disk of exports is away");
  }
  const auto free =
      static_cast<std::int64_t>(info.f_bavail) * static_cast<std::int64_t>(info.f_frsize);
  if (free - options_.reserve_bytes < sizes->volumes) {
    return fail(ErrorCode::kUnavailable, "the disk is full");
  }
  if (sizes->kept > 0 && sizes->kept + sizes->volumes > options_.total_bytes) {
    return fail(ErrorCode::kUnavailable, "other exports take all the room for exports");
  }
  return {};
}

Result<void> Exports::make(const ExportStore::Job& job) {
  std::error_code error;
  std::filesystem::create_directories(options_.exports, error);
  if (error) return fail(ErrorCode::kUnavailable, "the disk of exports cannot be written");
  if (auto room = check_room(job); !room) return room;
  const std::string path = options_.exports + "/" + job.id + ".zip";
  const std::string unfinished = options_.exports + "/.tmp-" + job.id;
  const auto leave_nothing = [&] {
    std::filesystem::remove(unfinished, error);
    std::filesystem::remove(path, error);
  };
  const auto bytes = write(job, unfinished);
  if (bytes) std::filesystem::rename(unfinished, path, error);
  if (!bytes || error) {
    leave_nothing();
    if (!bytes) return tl::unexpected(bytes.error());
    return fail(ErrorCode::kUnavailable, "the export cannot be renamed");
  }
  const auto wanted = store_.finish(job.id, *bytes);
  if (!wanted || !*wanted) leave_nothing();
  if (!wanted) return tl::unexpected(wanted.error());
  return {};
}

void Exports::look() {
  (void)store_.expire(clock_.wall());
  for (;;) {
    const auto job = store_.claim(clock_.wall(), kLease);
    if (!job || !*job) return;
    const ExportStore::Job& one = **job;
    const auto made = make(one);
    if (made) continue;
    log::warning("export not made",
                 {{"export", one.id}, {"reason", made.error().message}, {"waits", one.waits + 1}});
    if (made.error().code == ErrorCode::kUnavailable) {
      (void)store_.wait(one.id, clock_.wall() + pause_after(one.waits));
    }
  }
}

}  // namespace diaphane::api
