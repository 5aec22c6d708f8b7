// JSON of people: procam's own line, OpenPose, MediaPipe, Azure Kinect. All are parsed into a tree after a
// look at their size and depth, and read by paths that may be missing.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "joint_sets.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "procam/track/detail/json_depth.hpp"

namespace procam::people {
namespace {

using nlohmann::json;

/// What a reader gives up with; caught here, in this file.
struct Refused {
  const char* why;
};

json parsed(std::string_view text, std::size_t longest) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == text.npos || text[first] != '{') throw Refused{"it does not begin with {"};
  if (text.size() > longest) throw Refused{"it is too long"};
  if (!track::internal::is_shallow(text, limits::kSkeletonDepth)) throw Refused{"it is nested too deeply"};
  json root = json::parse(text.begin(), text.end(), nullptr, false);
  if (root.is_discarded()) throw Refused{"it is not JSON"};
  return root;
}

const json* find(const json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}
/// Throws unless there is such a list.
const json& list_at(const json& object, const char* name, const char* why) {
  const json* list = object.is_object() ? find(object, name) : nullptr;
  if (list == nullptr || !list->is_array()) throw Refused{why};
  return *list;
}
double number_in(const json& value, const char* why) {
  if (!value.is_number()) throw Refused{why};
  return value.get<double>();
}
void check_count(const json& people) {
  if (people.size() > limits::kPeople) throw Refused{"it holds more than 16 people"};
}

Skeleton read_person(const json& value) {
  Skeleton person;
  const json* joints = value.is_object() ? find(value, "joints") : nullptr;
  if (joints == nullptr || !joints->is_object()) throw Refused{"a person without joints"};
  if (const json* id = find(value, "id")) {
    if (!id->is_number_integer()) throw Refused{"an id is not an integer"};
    person.id = id->get<std::int64_t>();
  }
  for (const auto& [name, seen] : joints->items()) {
    const std::optional<Joint> joint = joint_of(name);
    if (!joint) throw Refused{"a joint of unknown name"};
    if (seen.is_null()) continue;
    if (!seen.is_array() || seen.size() < 3 || seen.size() > 4)
      throw Refused{"a joint is not [x, y, z] or [x, y, z, confidence]"};
    SeenJoint<Vec3> read;
    for (int i = 0; i < 3; ++i)
      read.position[i] = number_in(seen[std::size_t(i)], "a joint's coordinate is not a number");
    if (seen.size() == 4) read.confidence = number_in(seen[3], "a confidence is not a number");
    if (read.confidence == 0) continue;  // not seen
    person[*joint] = read;
  }
  return person;
}

SkeletonFrame read_frame(std::string_view line) {
  const json root = parsed(line, limits::kSkeletonLineBytes);
  SkeletonFrame frame;
  if (const json* stamp = find(root, "stamp")) frame.stamp = number_in(*stamp, "the stamp is not a number");
  if (const json* name = find(root, "frame")) {
    if (!name->is_string() || name->get_ref<const std::string&>().size() > 255)
      throw Refused{"the frame is not a name"};
    frame.frame = name->get<std::string>();
  }
  const json& people = list_at(root, "people", "people is missing or no list");
  check_count(people);
  for (const json& person : people) frame.people.push_back(read_person(person));
  if (const char* why = why_refused(frame)) throw Refused{why};
  return frame;
}

}  // namespace

ParsedSkeletons parse_skeletons(std::string_view lines) {
  ParsedSkeletons result;
  while (!lines.empty()) {
    const std::size_t end = lines.find('\n');
    const std::string_view line = lines.substr(0, end);
    lines = end == lines.npos ? std::string_view() : lines.substr(end + 1);
    if (line.find_first_not_of(" \t\r") == line.npos) continue;
    try {
      result.frames.push_back(read_frame(line));
    } catch (const Refused& refused) {
      ++result.malformed;
      result.why = refused.why;
    }
  }
  return result;
}

std::string to_json_line(const SkeletonFrame& frame) {
  char number[160];
  std::string text = "{";
  if (frame.stamp) {
    std::snprintf(number, sizeof number, "\"stamp\":%.17g,", *frame.stamp);
    text += number;
  }
  text +=
      "\"frame\":" + json(frame.frame).dump(-1, ' ', false, json::error_handler_t::replace) + ",\"people\":[";
  for (const Skeleton& person : frame.people) {
    if (&person != &frame.people.front()) text += ',';
    text += '{';
    if (person.id) text += "\"id\":" + std::to_string(*person.id) + ",";
    text += "\"joints\":{";
    bool is_first = true;
    for (std::size_t i = 0; i < kJointCount; ++i) {
      const auto& seen = person.joints[i];
      if (!seen) continue;
      const Vec3& p = seen->position;
      std::snprintf(number, sizeof number, "%s\"%s\":[%.9g,%.9g,%.9g,%.4g]", is_first ? "" : ",",
                    to_string(Joint(i)), p.x(), p.y(), p.z(), seen->confidence);
      text += number;
      is_first = false;
    }
    text += "}}";
  }
  return text + "]}\n";
}

PixelPeople parse_openpose(std::string_view text) {
  PixelPeople result;
  try {
    const json root = parsed(text, limits::kSkeletonFileBytes);
    const json& people = list_at(root, "people", "people is missing or no list");
    check_count(people);
    for (const json& one : people) {
      const json& points = list_at(one, "pose_keypoints_2d", "pose_keypoints_2d is missing");
      if (points.size() != 3 * internal::kBody25.size())
        throw Refused{"pose_keypoints_2d is not BODY_25's 75 numbers"};
      PixelSkeleton person;
      for (std::size_t i = 0; i < internal::kBody25.size(); ++i) {
        std::array<double, 3> v;
        for (std::size_t k = 0; k < 3; ++k) v[k] = number_in(points[3 * i + k], "a keypoint is not a number");
        if (!internal::kBody25[i] || !(v[2] > 0)) continue;
        if (!(std::abs(v[0]) <= 1e5 && std::abs(v[1]) <= 1e5))
          throw Refused{"a keypoint is far from any picture"};
        // Some builds report confidences a little above 1.
        person[*internal::kBody25[i]] = SeenJoint<Vec2>{Vec2(v[0], v[1]), std::min(v[2], 1.0)};
      }
      result.people.push_back(person);
    }
  } catch (const Refused& refused) {
    result.people.clear();
    result.why = refused.why;
  }
  return result;
}

HipCentredPeople parse_mediapipe(std::string_view text) {
  const auto read_landmark = [](const json& landmark, Vec3& position) {
    if (!landmark.is_object()) throw Refused{"a landmark is no object of x, y, z"};
    int k = 0;
    for (const char* axis : {"x", "y", "z"}) {
      const json* value = find(landmark, axis);
      if (value == nullptr) throw Refused{"a landmark is no object of x, y, z"};
      position[k++] = number_in(*value, "a landmark's coordinate is not a number");
    }
    if (!(position.cwiseAbs().maxCoeff() <= kFarthestJoint))
      throw Refused{"a landmark is not finite, or beyond 20 m"};
    const json* visibility = find(landmark, "visibility");
    return visibility == nullptr ? 1.0 : number_in(*visibility, "a visibility is not a number");
  };
  const auto is_complete = [](const json& landmarks) {
    return landmarks.is_array() && landmarks.size() == internal::kMediaPipe.size();
  };
  HipCentredPeople result;
  try {
    const json root = parsed(text, limits::kSkeletonFileBytes);
    const json& people = list_at(root, "worldLandmarks", "worldLandmarks is missing or no list");
    check_count(people);
    const json* pictures = find(root, "landmarks");
    for (std::size_t n = 0; n < people.size(); ++n) {
      if (!is_complete(people[n])) throw Refused{"a person has not 33 world landmarks"};
      HipCentredPerson person;
      for (std::size_t i = 0; i < internal::kMediaPipe.size(); ++i) {
        SeenJoint<Vec3> seen;
        seen.confidence = std::min(read_landmark(people[n][i], seen.position), 1.0);
        if (internal::kMediaPipe[i] && seen.confidence > 0)
          person.about_hips[*internal::kMediaPipe[i]] = seen;
      }
      if (pictures != nullptr && pictures->is_array() && n < pictures->size() &&
          is_complete((*pictures)[n])) {
        Vec3 left, right;
        read_landmark((*pictures)[n][23], left);
        read_landmark((*pictures)[n][24], right);
        person.hips_in_picture = (left + right).head<2>() / 2;
      }
      result.people.push_back(person);
    }
  } catch (const Refused& refused) {
    result.people.clear();
    result.why = refused.why;
  }
  return result;
}

ParsedSkeletons parse_azure_kinect(std::string_view text) {
  ParsedSkeletons result;
  try {
    const json root = parsed(text, limits::kSkeletonFileBytes);
    for (const json& moment : list_at(root, "frames", "frames is missing or no list")) {
      try {
        SkeletonFrame frame;
        frame.frame = "depth camera";
        if (!moment.is_object()) throw Refused{"a frame is no object"};
        if (const json* time = find(moment, "timestamp_usec"))
          frame.stamp = 1e-6 * number_in(*time, "timestamp_usec is not a number");
        const json& bodies = list_at(moment, "bodies", "bodies is missing or no list");
        check_count(bodies);
        for (const json& body : bodies) {
          const json& positions = list_at(body, "joint_positions", "joint_positions is missing or no list");
          const json* levels = find(body, "confidence_level");
          if (positions.size() != internal::kAzure.size()) throw Refused{"a body has not 32 joints"};
          std::vector<ForeignJoint> joints(positions.size());
          for (std::size_t i = 0; i < joints.size(); ++i) {
            if (!positions[i].is_array() || positions[i].size() != 3)
              throw Refused{"a joint is not three numbers"};
            for (std::size_t k = 0; k < 3; ++k)
              joints[i].position[Eigen::Index(k)] =
                  number_in(positions[i][k], "a joint is not three numbers");
            // Recordings without levels: the sample writes zeros for what it has not seen.
            joints[i].confidence = joints[i].position.isZero(0) ? 0 : 2;
            if (levels != nullptr && levels->is_array() && i < levels->size())
              joints[i].confidence =
                  int(std::clamp(number_in((*levels)[i], "a level is not a number"), 0.0, 3.0));
          }
          Skeleton person = from_joint_set(JointSet::kAzureKinect, joints);
          if (const json* id = find(body, "body_id"); id != nullptr && id->is_number_integer())
            person.id = id->get<std::int64_t>();
          frame.people.push_back(person);
        }
        if (const char* why = why_refused(frame)) throw Refused{why};
        result.frames.push_back(std::move(frame));
      } catch (const Refused& refused) {
        ++result.malformed;
        result.why = refused.why;
      }
    }
  } catch (const Refused& refused) {
    ++result.malformed;
    result.why = refused.why;
  }
  return result;
}

}  // namespace procam::people
