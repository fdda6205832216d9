#include "renderd/session/slice_wishes.h"

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

Result<void> SliceWishes::wish(const v1::SlicesWanted& wanted, const SliceStacks& stacks) {
  std::array<std::optional<std::uint32_t>, 3> wishes;
  for (int i = 0; i < wanted.slices_size(); ++i) {
    const std::string field = "slices[" + std::to_string(i) + "].";
    const v1::SlicesWanted::At& at = wanted.slices(i);
    const auto plane = number_of(at.plane());
    if (!plane || wishes[*plane]) {
      return fail(ErrorCode::kInvalid, "Request at most one slice per plane.", field + "plane");
    }
    if (at.index() >= stacks[*plane].slices) {
      return fail(ErrorCode::kInvalid, "This slice does not exist.", field + "index");
    }
    wishes[*plane] = at.index();
  }
  // Ignores numbers that were never sent.
  if (wanted.taken() <= seq_) taken_ = std::max(taken_, wanted.taken());
  for (std::size_t plane = 0; plane < wishes.size(); ++plane) {
    const bool being_made = making_ && making_->plane == plane && wishes[plane] == making_->index;
    const Sent& sent = sent_[plane];
    const bool on_its_way = sent.seq > taken_ && wishes[plane] == sent.index;
    if (being_made || on_its_way) wishes[plane].reset();
  }
  wanted_ = wishes;
  return {};
}

std::optional<SliceDue> SliceWishes::take() {
  if (!ready()) return std::nullopt;
  while (!wanted_[turn_]) turn_ = (turn_ + 1) % wanted_.size();
  making_ = SliceDue{turn_, *wanted_[turn_]};
  wanted_[turn_].reset();
  turn_ = (turn_ + 1) % wanted_.size();
  return making_;
}

std::uint64_t SliceWishes::depart() {
  ++seq_;
  if (making_) sent_[making_->plane] = {seq_, making_->index};
  making_.reset();
  return seq_;
}

void SliceWishes::give_up() { making_.reset(); }

void SliceWishes::put_back() {
  if (making_ && !wanted_[making_->plane]) wanted_[making_->plane] = making_->index;
  making_.reset();
}

void SliceWishes::forget() { wanted_ = {}; }

bool SliceWishes::waiting() const {
  return std::any_of(wanted_.begin(), wanted_.end(), [](const auto& one) { return one; });
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
