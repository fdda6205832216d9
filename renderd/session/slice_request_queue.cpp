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

namespace {

volume::Vector vector_of(const v1::Vec3& vector) { return {vector.x(), vector.y(), vector.z()}; }

/// Reads what a viewer requests. The numbers are not checked yet.
volume::ObliqueSlice oblique_of(const v1::ObliqueSlice& message) {
  volume::ObliqueSlice slice;
  slice.id = message.id();
  slice.columns = message.columns();
  slice.rows = message.rows();
  slice.first = vector_of(message.first());
  slice.right = vector_of(message.right());
  slice.down = vector_of(message.down());
  slice.thickness = message.thickness();
  slice.projection = projection_of(message.projection());
  return slice;
}

/// Reads what a viewer requests. The numbers are not checked yet.
volume::CurvedSlice curved_of(const v1::CurvedSlice& message) {
  volume::CurvedSlice slice;
  slice.id = message.id();
  slice.columns = message.columns();
  slice.rows = message.rows();
  for (const v1::Vec3& point : message.points()) slice.points.push_back(vector_of(point));
  slice.pixel = message.pixel();
  slice.angle = message.angle();
  slice.thickness = message.thickness();
  slice.projection = projection_of(message.projection());
  if (slice.columns == 0) slice.columns = volume::columns_along(slice.points, slice.pixel);
  return slice;
}

Result<SliceDue> curved_due_of(const v1::CurvedSlice& message, const volume::Header& header) {
  if (message.id() == 0) {
    return fail(ErrorCode::kInvalid, "A curved slice needs an ID.", "curved.id");
  }
  SliceDue due;
  due.curved = curved_of(message);
  if (const auto checked = volume::check(header, *due.curved); !checked) {
    return fail(checked.error().code, checked.error().message, "curved." + checked.error().field);
  }
  return due;
}

Result<SliceDue> due_of(const v1::SliceRequest::At& at, std::size_t plane,
                        const SliceStacks& stacks, const volume::Header& header) {
  if (!at.has_oblique()) {
    if (at.index() >= stacks.at(plane).slices) {
      return fail(ErrorCode::kInvalid, "This slice does not exist.", "index");
    }
    return SliceDue{plane, at.index(), std::nullopt, std::nullopt};
  }
  if (at.oblique().id() == 0) {
    return fail(ErrorCode::kInvalid, "An oblique slice needs an ID.", "oblique.id");
  }
  SliceDue due{plane, at.index(), oblique_of(at.oblique()), std::nullopt};
  if (const auto checked = volume::check(header, *due.oblique); !checked) {
    return fail(checked.error().code, checked.error().message, "oblique." + checked.error().field);
  }
  return due;
}

}  // namespace

std::uint64_t SliceDue::samples(const volume::Header& header) const {
  if (curved) return volume::samples_of(header, *curved);
  return oblique ? volume::samples_of(header, *oblique) : 0;
}

Result<void> SliceRequestQueue::replace(const v1::SliceRequest& request, const SliceStacks& stacks,
                                        const volume::Header& header) {
  std::array<std::optional<SliceDue>, kSlots> requested;
  for (int i = 0; i < request.slices_size(); ++i) {
    const std::string field = "slices[" + std::to_string(i) + "].";
    const v1::SliceRequest::At& at = request.slices(i);
    const auto plane = number_of(at.plane());
    const std::size_t slot = at.has_curved() ? volume::kPlanes.size() : plane.value_or(kSlots);
    if (slot >= kSlots || requested.at(slot)) {
      return fail(ErrorCode::kInvalid, "Request at most one slice per plane.", field + "plane");
    }
    auto due =
        at.has_curved() ? curved_due_of(at.curved(), header) : due_of(at, slot, stacks, header);
    if (!due) return fail(due.error().code, due.error().message, field + due.error().field);
    requested.at(slot) = *std::move(due);
  }
  // Ignores numbers that were never sent.
  if (request.taken() <= seq_) taken_ = std::max(taken_, request.taken());
  for (std::size_t slot = 0; slot < requested.size(); ++slot) {
    auto& one = requested.at(slot);
    const Sent& sent = sent_.at(slot);
    const bool is_in_flight = sent.seq > taken_ && one == sent.due;
    if (one == preparing_ || is_in_flight) one.reset();
  }
  requested_ = requested;
  return {};
}

std::optional<SliceDue> SliceRequestQueue::take() {
  if (!ready()) return std::nullopt;
  while (!requested_[turn_]) turn_ = (turn_ + 1) % requested_.size();
  preparing_ = requested_[turn_];
  requested_[turn_].reset();
  turn_ = (turn_ + 1) % requested_.size();
  return preparing_;
}

std::uint64_t SliceRequestQueue::depart() {
  ++seq_;
  if (preparing_) sent_.at(preparing_->slot()) = {seq_, *preparing_};
  preparing_.reset();
  return seq_;
}

void SliceRequestQueue::give_up() { preparing_.reset(); }

void SliceRequestQueue::put_back() {
  if (preparing_ && !requested_.at(preparing_->slot())) {
    requested_.at(preparing_->slot()) = preparing_;
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

volume::Projection projection_of(v1::Projection projection) {
  switch (projection) {
    case v1::PROJECTION_MAXIMUM:
      return volume::Projection::kMaximum;
    case v1::PROJECTION_MINIMUM:
      return volume::Projection::kMinimum;
    default:  // a number of a newer page, too
      return volume::Projection::kMean;
  }
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
