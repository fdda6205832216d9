#include "renderd/session/slice_request_queue.h"

#include <algorithm>
#include <string>

namespace diaphane::render {
namespace {

std::optional<std::size_t> number_of(v1::AnatomicalPlane plane) {
  for (std::size_t i = 0; i < volume::kPlanes.size(); ++i) {
    if (to_proto(volume::kPlanes[i]) == plane) return i;
  }
  return std::nullopt;
}

void set(v1::Vec3& out, const std::array<double, 3>& vector) {
  out.set_x(vector[0]);
  out.set_y(vector[1]);
  out.set_z(vector[2]);
}

}  // namespace

Result<void> SliceRequestQueue::replace(const v1::SliceRequest& request,
                                        const SliceStacks& stacks) {
  std::array<std::optional<std::uint32_t>, 3> requested;
  for (int i = 0; i < request.slices_size(); ++i) {
    const std::string field = "slices[" + std::to_string(i) + "].";
    const v1::SliceRequest::At& at = request.slices(i);
    const auto plane = number_of(at.plane());
    if (!plane || requested[*plane]) {
      return fail(ErrorCode::kInvalid, "Request at most one slice per plane.", field + "plane");
    }
    if (at.index() >= stacks[*plane].slices) {
      return fail(ErrorCode::kInvalid, "This slice does not exist.", field + "index");
    }
    requested[*plane] = at.index();
  }
  // Ignores numbers that were never sent.
  if (request.taken() <= seq_) taken_ = std::max(taken_, request.taken());
  for (std::size_t plane = 0; plane < requested.size(); ++plane) {
    const bool in_preparation =
        preparing_ && preparing_->plane == plane && requested[plane] == preparing_->index;
    const Sent& sent = sent_[plane];
    const bool in_flight = sent.seq > taken_ && requested[plane] == sent.index;
    if (in_preparation || in_flight) requested[plane].reset();
  }
  requested_ = requested;
  return {};
}

std::optional<SliceDue> SliceRequestQueue::take() {
  if (!ready()) return std::nullopt;
  while (!requested_[turn_]) turn_ = (turn_ + 1) % requested_.size();
  preparing_ = SliceDue{turn_, *requested_[turn_]};
  requested_[turn_].reset();
  turn_ = (turn_ + 1) % requested_.size();
  return preparing_;
}

std::uint64_t SliceRequestQueue::depart() {
  ++seq_;
  if (preparing_) sent_[preparing_->plane] = {seq_, preparing_->index};
  preparing_.reset();
  return seq_;
}

void SliceRequestQueue::give_up() { preparing_.reset(); }

void SliceRequestQueue::put_back() {
  if (preparing_ && !requested_[preparing_->plane]) {
    requested_[preparing_->plane] = preparing_->index;
  }
  preparing_.reset();
}

void SliceRequestQueue::forget() { requested_ = {}; }

bool SliceRequestQueue::waiting() const {
  return std::any_of(requested_.begin(), requested_.end(), [](const auto& one) { return one; });
}

SliceStacks stacks_of(const volume::Header& header) {
  SliceStacks stacks;
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    stacks[i] = volume::plan_stack(header, volume::kPlanes[i]);
  }
  return stacks;
}

v1::AnatomicalPlane to_proto(volume::Plane plane) {
  switch (plane) {
    case volume::Plane::kCoronal:
      return v1::CORONAL;
    case volume::Plane::kSagittal:
      return v1::SAGITTAL;
    case volume::Plane::kAxial:
      break;
  }
  return v1::AXIAL;
}

v1::SliceStack to_proto(const volume::SliceStack& stack) {
  v1::SliceStack message;
  message.set_plane(to_proto(stack.plane));
  message.set_columns(stack.columns);
  message.set_rows(stack.rows);
  message.set_slices(stack.slices);
  set(*message.mutable_first(), stack.first);
  set(*message.mutable_right(), stack.right);
  set(*message.mutable_down(), stack.down);
  set(*message.mutable_next(), stack.next);
  return message;
}

}  // namespace diaphane::render
