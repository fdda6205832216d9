#include "ingest/registration/search.h"

#include <itkImage.h>
#include <itkMattesMutualInformationImageToImageMetricv4.h>
#include <itkMultiThreaderBase.h>
#include <itkPointSet.h>
#include <itkVersorRigid3DTransform.h>

#include <algorithm>
#include <cmath>

namespace diaphane::ingest {
namespace {

using Image = itk::Image<float, 3>;
using Metric = itk::MattesMutualInformationImageToImageMetricv4<Image, Image>;
using Transform = itk::VersorRigid3DTransform<double>;
using Places = Metric::FixedSampledPointSetType;

/// Sums by several threads would depend on their order, and the sandbox allows none.
void use_one_thread() {
  itk::MultiThreaderBase::SetGlobalDefaultThreader(itk::MultiThreaderBase::ThreaderEnum::Platform);
  itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(1);
  itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(1);
}

Image::Pointer image_of(const CoarseScan& scan) {
  auto image = Image::New();
  image->SetRegions(Image::SizeType{{scan.size[0], scan.size[1], scan.size[2]}});
  image->SetSpacing(scan.spacing.data());
  image->SetOrigin(scan.origin.data());
  Image::DirectionType direction;
  for (unsigned row = 0; row < 3; ++row) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      direction(row, axis) = scan.direction[3 * std::size_t{row} + axis];
    }
  }
  image->SetDirection(direction);
  image->Allocate();
  std::copy(scan.values.begin(), scan.values.end(), image->GetBufferPointer());
  return image;
}

Transform::ParametersType parameters_of(const Pose& pose) {
  Transform::ParametersType parameters(6);
  std::copy(pose.begin(), pose.end(), parameters.begin());
  return parameters;
}

Transform::Pointer transform_about(const Point& centre) {
  auto transform = Transform::New();
  Transform::InputPointType point;
  std::copy(centre.begin(), centre.end(), point.Begin());
  transform->SetCenter(point);
  return transform;
}

}  // namespace

struct InformationSearch::Impl {
  Image::Pointer fixed, moving;
  Transform::Pointer transform;
  Metric::Pointer metric;
  double radius = 1;

  void begin(const Pose& pose) const {
    transform->SetParameters(parameters_of(pose));
    metric->Initialize();
  }
};

InformationSearch::InformationSearch(const CoarseScan& fixed, const CoarseScan& moving,
                                     Point centre, double radius)
    : impl_(std::make_unique<Impl>()) {
  use_one_thread();
  impl_->fixed = image_of(fixed);
  impl_->moving = image_of(moving);
  impl_->transform = transform_about(centre);
  impl_->radius = radius;
  impl_->metric = Metric::New();
  constexpr unsigned kBins = 32;
  impl_->metric->SetNumberOfHistogramBins(kBins);
  impl_->metric->SetFixedImage(impl_->fixed);
  impl_->metric->SetMovingImage(impl_->moving);
  impl_->metric->SetVirtualDomainFromImage(impl_->fixed);
  impl_->metric->SetMovingTransform(impl_->transform);
  impl_->metric->SetUseFixedImageGradientFilter(false);
  impl_->metric->SetUseMovingImageGradientFilter(false);
  impl_->metric->SetMaximumNumberOfWorkUnits(1);
}
InformationSearch::~InformationSearch() = default;
InformationSearch::InformationSearch(InformationSearch&&) noexcept = default;

void InformationSearch::set_places(const std::vector<Point>& places) {
  auto set = Places::New();
  for (std::size_t i = 0; i < places.size(); ++i) {
    Places::PointType point;
    std::copy(places[i].begin(), places[i].end(), point.Begin());
    set->SetPoint(i, point);
  }
  impl_->metric->SetFixedSampledPointSet(set);
  impl_->metric->SetUseSampledPointSet(true);
}

double InformationSearch::information(const Pose& pose) const {
  try {
    impl_->begin(pose);
    return -impl_->metric->GetValue();
  } catch (const itk::ExceptionObject&) {  // too few places lie in both scans
    return -1;
  }
}

Pose InformationSearch::climb(const Pose& start, double step) const {
  constexpr int kMostSteps = 150;
  constexpr double kRelaxation = 0.6;
  Pose pose = start, best = start, last{};
  double most = -1;
  // ITK's optimizers measure steps in the units of the parameters, in which a versor and a shift
  // cannot be compared. Here, steps of both kinds move places by the same distance.
  const auto unit = [&](std::size_t i) { return i < 3 ? 2 * impl_->radius : 1; };
  try {
    impl_->begin(start);
    for (double length = step, i = 0; length > step / 256 && i < kMostSteps; ++i) {
      Metric::MeasureType value = 0;
      Metric::DerivativeType uphill(6);
      impl_->transform->SetParameters(parameters_of(pose));
      impl_->metric->GetValueAndDerivative(value, uphill);
      if (-value > most) {
        most = -value;
        best = pose;
      }
      double squares = 0, along = 0;
      Pose direction{};
      for (unsigned k = 0; k < 6; ++k) {
        direction[k] = uphill[k] / unit(k);
        squares += direction[k] * direction[k];
        along += direction[k] * last[k];
      }
      if (!(squares > 0)) break;
      if (along < 0) length *= kRelaxation;
      for (std::size_t k = 0; k < 6; ++k) {
        pose[k] += direction[k] * length / std::sqrt(squares) / unit(k);
      }
      last = direction;
    }
  } catch (const itk::ExceptionObject&) {  // it left the other scan
  }
  return best;
}

volume::Matrix matrix_of(const Pose& pose, const Point& centre) {
  const auto transform = transform_about(centre);
  transform->SetParameters(parameters_of(pose));
  volume::Matrix matrix = volume::kIdentity;
  for (unsigned row = 0; row < 3; ++row) {
    for (unsigned axis = 0; axis < 3; ++axis) {
      matrix[4 * std::size_t{row} + axis] = transform->GetMatrix()(row, axis);
    }
    matrix[4 * std::size_t{row} + 3] = transform->GetOffset()[row];
  }
  return matrix;
}

}  // namespace diaphane::ingest
