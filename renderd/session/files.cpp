#include "renderd/session/files.h"

#include <utility>

#include "renderd/scene/file_order.h"

namespace diaphane::render {
namespace {

bool is_greeted(const SessionState& state, std::uint64_t connection) {
  const Receiver* const receiver = state.audience.find(connection);
  return receiver && receiver->greeted;
}

effect::Send refusal(std::uint64_t connection, Error why) {
  why.field = "file";
  return problem_to(connection, why);
}

}  // namespace

Effects Files::handle(const KeyViewSent& event, const SessionState& state) {
  if (!is_greeted(state, event.connection)) return {};
  if (const auto noted = note_key_view(key_views_, event.view); !noted) {
    return {refusal(event.connection, noted.error())};
  }
  if (event.view.index() == 0) marks_.clear();
  return {};
}

Effects Files::handle(const FileMarkSent& event, const SessionState& state) {
  if (!is_greeted(state, event.connection)) return {};
  if (const auto noted = note_file_mark(marks_, event.mark); !noted) {
    return {refusal(event.connection, noted.error())};
  }
  return {};
}

Effects Files::handle(FileRequested event, const SessionState& state) {
  if (!is_greeted(state, event.connection)) return {};
  if (event.request.kind_case() == v1::FileRequest::KIND_NOT_SET) return give_up();
  if (!event.volume) {
    return {
        refusal(event.connection, {ErrorCode::kUnavailable, "The scan is not loaded yet.", {}})};
  }
  if (file_) {
    return {
        refusal(event.connection, {ErrorCode::kConflict, "A file is already being created.", {}})};
  }
  file_ = File{++files_, event.connection};
  return {effect::StartFile{file_->id, event.request, std::exchange(key_views_, {}),
                            std::exchange(marks_, {}), std::move(event.volume)}};
}

Effects Files::handle(const FileTaken& event, const SessionState& state) {
  if (!is_greeted(state, event.connection)) return {};
  if (!file_ || file_->connection != event.connection) return {};
  return {effect::AcknowledgeFile{file_->id, event.seq}};
}

Effects Files::handle(FileMessage event) {
  if (!makes(event.file)) return {};
  Effects effects;
  effects.emplace_back(effect::Send{file_->connection, std::move(event.message)});
  if (event.last) {
    // Frees the reservation, whether or not the viewer stays.
    effects.emplace_back(effect::StopFile{event.file});
    file_.reset();
  }
  return effects;
}

Effects Files::handle(FileRefused event) {
  if (!makes(event.file)) return {};
  if (key_views_.empty()) {
    key_views_ = std::move(event.keys);
    marks_ = std::move(event.marks);
  }
  return {refusal(std::exchange(file_, std::nullopt)->connection, std::move(event.why))};
}

Effects Files::handle(const ViewerLeft& event) {
  if (!file_ || file_->connection != event.connection) return {};
  return give_up();
}

Effects Files::handle(SessionEnded) { return give_up(); }

Effects Files::give_up() {
  if (!file_) return {};
  return {effect::StopFile{std::exchange(file_, std::nullopt)->id}};
}

}  // namespace diaphane::render
