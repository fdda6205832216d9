#include "api/stream/worker_link.h"

#include <locale>
#include <sstream>
#include <utility>

namespace diaphane::api::stream {

namespace v1 = diaphane::v1;

namespace {

v1::Viewer to_proto(SessionViewer viewer) {
  switch (viewer) {
    case SessionViewer::kOwner:
      return v1::VIEWER_OWNER;
    case SessionViewer::kShared:
      return v1::VIEWER_SHARED;
    case SessionViewer::kPublic:
      return v1::VIEWER_PUBLIC;
    case SessionViewer::kLinkVisitor:
      return v1::VIEWER_LINK_VISITOR;
    case SessionViewer::kSampleVisitor:
      return v1::VIEWER_SAMPLE_VISITOR;
    case SessionViewer::kGuest:
      break;
  }
  return v1::VIEWER_LIVE_GUEST;
}

}  // namespace

std::shared_ptr<WorkerLink> WorkerLink::open(const std::shared_ptr<grpc::Channel>& channel,
                                             const Attachment& attachment,
                                             std::weak_ptr<LinkEvents> events) {
  std::shared_ptr<WorkerLink> link(new WorkerLink(channel, std::move(events)));
  v1::Open& open = *link->request_.mutable_open();
  open.set_session_id(attachment.session.id);
  open.set_volume_id(attachment.session.data_set_id);
  open.set_placement(attachment.placement);
  if (!attachment.scene.empty()) {
    // A stored scene that can no longer be parsed is ignored, and the session starts with the first
    // preset.
    if (open.mutable_scene()->ParseFromString(attachment.scene)) {
      open.set_input_seq(attachment.input_seq);
    } else {
      open.clear_scene();
    }
  }
  if (attachment.width != 0 && attachment.height != 0) {
    open.mutable_viewport()->set_width(attachment.width);
    open.mutable_viewport()->set_height(attachment.height);
  }
  open.set_participant(attachment.participant);
  open.set_name(attachment.name);
  open.set_presenter(attachment.presenter);
  open.set_user_id(attachment.session.user_id);
  open.set_link(attachment.link);
  open.set_viewer(to_proto(attachment.viewer));
  open.set_slices(attachment.slices);
  open.set_downloads(attachment.downloads);
  open.set_guest_slices(attachment.guest_slices);
  open.set_visitor(attachment.visitor);
  if (!attachment.session.over.empty()) {
    open.mutable_second()->set_volume_id(attachment.session.over);
    std::istringstream motion(attachment.to_first);
    motion.imbue(std::locale::classic());
    for (double number = 0; motion >> number;) open.mutable_second()->add_to_first(number);
  }
  link->self_ = link;
  link->reading_ = true;
  link->writing_ = true;
  link->stub_->async()->Attach(&link->context_, link.get());
  link->AddHold();  // writes are started outside gRPC's callbacks
  link->StartRead(&link->reply_);
  link->StartWrite(&link->request_);
  link->StartCall();
  return link;
}

WorkerLink::WorkerLink(const std::shared_ptr<grpc::Channel>& channel,
                       std::weak_ptr<LinkEvents> events)
    : stub_(v1::RenderWorker::NewStub(channel)), events_(std::move(events)) {
  // The call to an unavailable worker fails at once, so that the viewer requests another worker.
  context_.set_wait_for_ready(false);
}

bool WorkerLink::send(std::string client_message) {
  Step step = Step::kNone;
  bool room = true;
  {
    const std::lock_guard lock(mutex_);
    if (finishing_ || writes_ended_) return true;
    unsent_.push_back(std::move(client_message));
    step = next_write();
    room = unsent_.size() < kMostUnsent;
    back_pressured_ = !room;
  }
  carry_out(step);
  return room;
}

void WorkerLink::delivered() {
  {
    const std::lock_guard lock(mutex_);
    --undelivered_;
    if (reading_ || reads_ended_ || undelivered_ >= kMostUndelivered) return;
    reading_ = true;
  }
  StartRead(&reply_);
}

void WorkerLink::finish() {
  Step step = Step::kNone;
  bool resume = false;
  {
    const std::lock_guard lock(mutex_);
    if (finishing_) return;
    finishing_ = true;
    step = next_write();
    // The viewer is gone, so the worker's messages are read and dropped until the call ends.
    if (!reading_ && !reads_ended_) resume = reading_ = true;
  }
  if (resume) StartRead(&reply_);
  carry_out(step);
}

void WorkerLink::cancel() {
  context_.TryCancel();
  finish();
}

void WorkerLink::OnReadDone(bool ok) {
  if (!ok) {
    Step step = Step::kNone;
    {
      const std::lock_guard lock(mutex_);
      reading_ = false;
      reads_ended_ = true;
      writes_ended_ = true;
      unsent_.clear();
      step = next_write();
    }
    carry_out(step);
    return;
  }
  std::string message = std::move(*reply_.mutable_server_message());
  bool deliver = false;
  {
    const std::lock_guard lock(mutex_);
    deliver = !finishing_;
    if (deliver) ++undelivered_;
  }
  // The message is delivered while this read still counts as in progress. Otherwise delivered()
  // could start the next read on another of gRPC's threads, and its message could overtake this
  // one.
  if (deliver) {
    if (const auto events = events_.lock()) {
      events->on_link_message(std::move(message));
    } else {
      cancel();
    }
  }
  bool more = false;
  {
    const std::lock_guard lock(mutex_);
    more = reading_ = finishing_ || undelivered_ < kMostUndelivered;
  }
  if (more) StartRead(&reply_);
}

void WorkerLink::OnWriteDone(bool ok) {
  Step step = Step::kNone;
  bool opened = false, writable = false;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (ok) {
      opened = !std::exchange(open_, true);
    } else {
      writes_ended_ = true;
      unsent_.clear();
    }
    step = next_write();
    if (back_pressured_ && unsent_.size() < kMostUnsent / 2) {
      back_pressured_ = false;
      writable = true;
    }
  }
  carry_out(step);
  if (!opened && !writable) return;
  if (const auto events = events_.lock()) {
    if (opened) events->on_link_open();
    if (writable) events->on_link_writable();
  }
}

void WorkerLink::OnDone(const grpc::Status& status) {
  const std::shared_ptr<WorkerLink> alive = std::move(self_);
  if (const auto events = events_.lock()) events->on_link_ended(status);
}

void WorkerLink::OnWritesDoneDone(bool) {
  Step step = Step::kNone;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    step = next_write();
  }
  carry_out(step);
}

WorkerLink::Step WorkerLink::next_write() {
  if (writing_) return Step::kNone;
  if (!writes_ended_ && !unsent_.empty()) {
    writing_ = true;
    request_.set_client_message(std::move(unsent_.front()));
    unsent_.pop_front();
    return Step::kWrite;
  }
  if (!writes_ended_ && finishing_) {
    writing_ = writes_ended_ = true;
    return Step::kWritesDone;
  }
  // The hold is needed until the reads have ended, because another read may start until then.
  if (reads_ended_ && !std::exchange(released_, true)) return Step::kRelease;
  return Step::kNone;
}

void WorkerLink::carry_out(Step step) {
  switch (step) {
    case Step::kNone:
      break;
    case Step::kWrite:
      StartWrite(&request_);
      break;
    case Step::kWritesDone:
      StartWritesDone();
      break;
    case Step::kRelease:
      RemoveHold();
      break;
  }
}

}  // namespace diaphane::api::stream
