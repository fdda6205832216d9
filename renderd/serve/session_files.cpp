#include <algorithm>

#include "common/log.h"
#include "common/try.h"
#include "renderd/serve/session_turn.h"

// LiveSession: makes videos and large pictures for download (docs/adr/0031).

namespace diaphane::render {
namespace {

/// Files that a worker makes at a time. Each holds a film of its own and up to 48 MiB of data.
constexpr int kMostFiles = 2;

// The same order always gives the same file.
constexpr std::uint64_t kFileSeed = 1;

/// Reserves one of the worker's files for the lifetime of the result. Returns null if none is free.
std::shared_ptr<const void> place_among(std::atomic<int>& files) {
  if (++files <= kMostFiles) {
    return {&files, [&files](const void*) { --files; }};
  }
  --files;
  return nullptr;
}

}  // namespace

/// Connects the work on a file to the session.
class LiveSession::FileLink final : public FileSink {
 public:
  FileLink(std::weak_ptr<LiveSession> session, std::uint64_t file)
      : session_(std::move(session)), file_(file) {}

  void progress(double done) override {
    v1::ServerMessage message;
    message.mutable_file_progress()->set_done(done);
    say(std::move(message));
  }
  void part(std::uint64_t seq, std::string bytes, bool last) override {
    v1::ServerMessage message;
    v1::FilePart& part = *message.mutable_file_part();
    part.set_seq(seq);
    part.set_data(std::move(bytes));
    part.set_last(last);
    say(std::move(message), last);
  }
  void ended(const Error& why) override {
    log::warning("file_failed", {{"code", to_string(why.code)}});
    v1::ServerMessage message;
    *message.mutable_problem() = problem_of({why.code, why.message, "file"}, 0, false);
    say(std::move(message), true);
  }

 private:
  void say(v1::ServerMessage message, bool last = false) {
    if (const auto session = session_.lock())
      session->on_file_message(file_, std::move(message), last);
  }

  const std::weak_ptr<LiveSession> session_;
  const std::uint64_t file_;
};

void LiveSession::carry_out(effect::StartFile& effect) {
  auto file = begin_file(effect);
  {
    const Turn turn(*this);
    if (!file) {
      return apply(files_.handle(
          FileRefused{effect.file, file.error(), std::move(effect.keys), std::move(effect.marks)}));
    }
    if (!files_.makes(effect.file)) return;  // given up meanwhile
    file_ = *file;
  }
  file->work->start();
}

FindHidden LiveSession::hidden_in(const DeviceVolume& volume) const {
  return [coarse = parts_.stats.of(volume).coarse, second = coarse_second()](
             const v1::Scene& scene, Canvas canvas, const std::vector<Double3>& places) {
    return coarse ? hidden_places(*coarse, scene, canvas, places, second)
                  : std::vector<bool>(places.size());
  };
}

Result<LiveSession::File> LiveSession::begin_file(effect::StartFile& effect) {
  auto place = place_among(parts_.files);
  if (!place) {
    return fail(ErrorCode::kTooMany,
                "Too many files are being created right now. Try again later.");
  }
  auto marks = FileMarks::make(std::exchange(effect.marks, {}), effect.request.mark_unit(),
                               hidden_in(*effect.volume));
  DIAPHANE_TRY(marks);
  const std::uint32_t phases = effect.volume->header().phase_count();
  auto maker =
      make_file_maker(effect.request, std::exchange(effect.keys, {}), std::move(*marks), phases);
  DIAPHANE_TRY(maker);
  auto renderer = parts_.home->engine.renderer(effect.volume, kFileSeed, 0, kFileMethod);
  DIAPHANE_TRY(renderer);
  if (second_) DIAPHANE_TRY((*renderer)->set_second(second_, facts_.second->to_first));
  auto link = std::make_shared<FileLink>(weak_from_this(), effect.file);
  // The work owns the reservation, also while a lane still holds the work.
  auto took = [&meter = parts_.gpu_time, user = facts_.charged_to,
               place = std::move(place)](double seconds) { meter.add(user, seconds); };
  FileWork::FindVolume find;
  if (phases > 1) {
    find = [&volumes = parts_.volumes, id = facts_.volume_id, phases](const v1::Scene& scene,
                                                                      auto ready) {
      const std::uint32_t phase = std::min(scene.volume_phase(), phases - 1);
      volumes.get({id, scene.show_table(), phase}, std::move(ready));
    };
  }
  auto work = std::make_shared<FileWork>(parts_.home->runner, parts_.encoders, std::move(*renderer),
                                         std::move(*maker), link, std::move(took), std::move(find));
  return File{effect.file, std::move(link), std::move(work)};
}

void LiveSession::carry_out(const effect::AcknowledgeFile& effect) {
  std::shared_ptr<FileWork> work;
  {
    const std::lock_guard lock(mutex_);
    if (file_ && file_->id == effect.file) work = file_->work;
  }
  if (work) work->taken(effect.seq);
}

void LiveSession::carry_out(const effect::StopFile& effect) {
  std::optional<File> stopped;
  {
    const std::lock_guard lock(mutex_);
    if (file_ && file_->id == effect.file) stopped = std::exchange(file_, std::nullopt);
  }
  if (stopped) stopped->work->stop();
}

void LiveSession::on_file_message(std::uint64_t file, v1::ServerMessage message, bool last) {
  const Turn turn(*this);
  apply(files_.handle(FileMessage{file, std::move(message), last}));
}

}  // namespace diaphane::render
