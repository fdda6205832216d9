#include "common/log.h"
#include "common/try.h"
#include "renderd/scene/file_order.h"
#include "renderd/serve/live_session.h"

// LiveSession: films and large pictures for download (docs/adr/0031).

namespace diaphane::render {
namespace {

/// Per worker, because each holds its own film and up to 48 MiB.
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

/// Connects a file to the connection that requested it.
class LiveSession::FileLink final : public FileSink {
 public:
  FileLink(std::weak_ptr<LiveSession> session, std::uint64_t connection)
      : session_(std::move(session)), connection_(connection) {}

  std::uint64_t connection() const { return connection_; }

  void progress(double done) override {
    v1::ServerMessage message;
    message.mutable_file_progress()->set_done(done);
    say(message);
  }
  void part(std::uint64_t seq, std::string bytes, bool last) override {
    v1::ServerMessage message;
    v1::FilePart& part = *message.mutable_file_part();
    part.set_seq(seq);
    part.set_data(std::move(bytes));
    part.set_last(last);
    say(message, last);
  }
  void ended(const Error& why) override {
    log::warning("file_failed", {{"code", to_string(why.code)}});
    v1::ServerMessage message;
    *message.mutable_problem() = problem_of({why.code, why.message, "file"}, 0, false);
    say(message, true);
  }

 private:
  void say(const v1::ServerMessage& message, bool last = false) {
    if (const auto session = session_.lock()) session->send_of_file(*this, message, last);
  }

  const std::weak_ptr<LiveSession> session_;
  const std::uint64_t connection_;
};

void LiveSession::receive_file(std::uint64_t connection, const v1::ClientMessage& message) {
  std::shared_ptr<FileWork> taken, begun;
  {
    const std::lock_guard lock(mutex_);
    const Receiver* const receiver = state_.audience.find(connection);
    if (!receiver || !receiver->greeted) return;
    const auto refuse = [&](Error why) {
      why.field = "file";
      send_problem(connection, why);
    };
    if (message.has_key_view()) {
      if (auto noted = note_key_view(key_views_, message.key_view()); !noted) refuse(noted.error());
    } else if (message.has_file_taken()) {
      if (file_ && file_->connection == connection) taken = file_->work;
    } else if (message.file().kind_case() == v1::FileRequest::KIND_NOT_SET) {
      give_up_file();
    } else if (auto file = begin_file(connection, message.file())) {
      begun = std::move(*file);
    } else {
      refuse(file.error());
    }
  }
  if (taken) taken->taken(message.file_taken().seq());
  if (begun) begun->start();
}

Result<std::shared_ptr<FileWork>> LiveSession::begin_file(std::uint64_t connection,
                                                          const v1::FileRequest& request) {
  if (!volume_ || ended_) return fail(ErrorCode::kUnavailable, "The scan is not loaded yet.");
  if (file_) return fail(ErrorCode::kConflict, "A file is already being created.");
  auto place = place_among(parts_.files);
  if (!place) {
    return fail(ErrorCode::kTooMany,
                "Too many files are being created right now. Try again later.");
  }
  auto maker = make_file_maker(request, std::move(key_views_));
  key_views_.clear();
  DIAPHANE_TRY(maker);
  auto renderer = parts_.engine.renderer(volume_, kFileSeed, 0, kLiveMethod);
  DIAPHANE_TRY(renderer);
  auto link = std::make_shared<FileLink>(weak_from_this(), connection);
  // The work owns the reservation, also while a lane still holds the work.
  auto took = [&meter = parts_.gpu_time, user = facts_.charged_to,
               place = std::move(place)](double seconds) { meter.add(user, seconds); };
  auto work = std::make_shared<FileWork>(parts_.runner, parts_.encoders, std::move(*renderer),
                                         std::move(*maker), link, std::move(took));
  file_ = File{connection, std::move(link), work};
  return work;
}

void LiveSession::send_of_file(const FileLink& link, const v1::ServerMessage& message, bool last) {
  const std::lock_guard lock(mutex_);
  if (!file_ || file_->link.get() != &link) return;
  send(link.connection(), message);
  // Frees the reservation, whether or not the viewer stays.
  if (last) file_.reset();
}

void LiveSession::give_up_file() {
  if (file_) file_->work->stop();
  file_.reset();
}

void LiveSession::give_up_file_of(std::uint64_t connection) {
  if (file_ && file_->connection == connection) give_up_file();
}

}  // namespace diaphane::render
