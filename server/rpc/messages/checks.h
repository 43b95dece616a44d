// Checks of fields that many requests have.
#pragma once

#include <absl/status/statusor.h>
#include <google/protobuf/repeated_field.h>

#include <memory>
#include <optional>
#include <string>

#include "lucerna/v1/accuracy.pb.h"
#include "proto/common/answer_size.h"
#include "proto/common/status_macros.h"
#include "server/queries/queries.h"
#include "server/rpc/messages/task.h"

namespace lucerna::rpc {

/// INVALID_ARGUMENT if the id is empty, NOT_FOUND if the scene is not loaded.
absl::StatusOr<StoredScene> find_stored(const CallContext& context, const std::string& scene_id);
/// The same, and counts as a use of the scene.
absl::StatusOr<std::shared_ptr<const Scene>> find_scene(const CallContext& context,
                                                        const std::string& scene_id);
/// The index of the light with this id.  NOT_FOUND if the scene does not have it.
absl::StatusOr<std::uint32_t> find_light(const Scene& scene, std::uint64_t light_id);
/// The index of the light with this name.  NOT_FOUND if the scene does not have it, and
/// INVALID_ARGUMENT if several lights have it.  `field`: of the request, for the error.
absl::StatusOr<std::uint32_t> find_named_light(const Scene& scene, const std::string& name,
                                               const std::string& field);
/// The light of a request with the fields `light_id` and `light_name`.  INVALID_ARGUMENT unless
/// exactly one of them is given.
absl::StatusOr<std::uint32_t> find_light(const Scene& scene, std::optional<std::uint64_t> light_id,
                                         const std::string& light_name);
/// For a request that must name a light: INVALID_ARGUMENT if it does not.
template <typename Request>
absl::StatusOr<std::uint32_t> find_required_light(const Scene& scene, const Request& request) {
  const auto id =
      request.light_id() != 0 ? std::optional<std::uint64_t>(request.light_id()) : std::nullopt;
  return find_light(scene, id, request.light_name());
}
/// For a request that may name a light.
template <typename Request>
absl::StatusOr<std::optional<std::uint32_t>> find_light_if_named(const Scene& scene,
                                                                 const Request& request) {
  if (!names_light(request)) return std::optional<std::uint32_t>();
  const auto id =
      request.has_light_id() ? std::optional<std::uint64_t>(request.light_id()) : std::nullopt;
  LUCERNA_ASSIGN_OR_RETURN(const std::uint32_t light, find_light(scene, id, request.light_name()));
  return std::optional<std::uint32_t>(light);
}

/// `field`: the name of the Points field.  Checks the number of offsets, not their values.
absl::StatusOr<PointArray> check_points(const CallContext& context, const std::string& field,
                                        const v1::Points& points);
/// A view of the field.  Requires three numbers for each of `items`, or none if `optional`.
absl::StatusOr<std::span<const float>> check_triples(
    const std::string& field, const google::protobuf::RepeatedField<float>& v, std::size_t items,
    const std::string& of, bool optional);
/// 0 if unset.
absl::StatusOr<double> check_time(double time_s);
absl::Status check_lease(double lease_s);
/// Nothing if unset.  Requires a finite number that is not negative.
absl::StatusOr<std::optional<float>> check_position_error(bool has, float position_error_m);
/// At most kMostWavelengths, each in [100, 1e6] nm; in any order.  A view of the request.
absl::StatusOr<std::span<const double>> check_wavelengths(
    const google::protobuf::RepeatedField<double>& wavelengths_nm);
/// INVALID_ARGUMENT for wavelengths in a scene whose media have a colour.
absl::Status check_grey_media(const Scene& scene, std::span<const double> wavelengths_nm);

/// RESOURCE_EXHAUSTED if the answer to this many `items` exceeds the message size.  So nothing is
/// computed that cannot be sent, and an int can count the entries of every array.  `field` names
/// the items in the error.
absl::Status check_answer_size(const CallContext& context, const std::string& field,
                               std::uint64_t items, const AnswerSize& size);

template <typename Number>
std::span<const Number> view(const google::protobuf::RepeatedField<Number>& v) {
  return {v.data(), static_cast<std::size_t>(v.size())};
}

/// Fills the field with `n` zeros.  Requires that check_answer_size() accepted them.
template <typename T>
T* fill(google::protobuf::RepeatedField<T>* field, std::size_t n) {
  field->Resize(static_cast<int>(n), T{});
  return field->mutable_data();
}

/// Fills the field with `n` zero bits.
std::uint8_t* fill_bits(std::string* bits, std::size_t n);

/// Clears the field if every item is OK.
void drop_if_all_ok(google::protobuf::RepeatedField<int>* status);

/// Sets the counts of the work, not the times.
void set_counts(v1::Cost* cost, const WorkCounts& work);

/// Completes the answer to a batch.
template <typename Response>
absl::Status finish_batch(Response* response, const WorkCounts& work = {}) {
  set_counts(response->mutable_cost(), work);
  drop_if_all_ok(response->mutable_status());
  return absl::OkStatus();
}

}  // namespace lucerna::rpc
