#include "procam/io/marker_map_file.hpp"

#include <charconv>
#include <set>

#include "document/shared_fields.hpp"
#include "procam/core/board/marker_dictionary.hpp"
#include "procam/io/text.hpp"

namespace procam::io {

static void fields(Fields& f, PlacedMarker& marker) {
  f.field("id", marker.id);
  f.field("size", marker.size);
  f.check(marker.size > 0, "size", "the size is not positive", "give the black square's side in metres");
  f.field("world_from_marker", marker.world_from_marker);
}

static void fields(Fields& f, MarkerMap& map) {
  header(f, "procam-markers", 1);
  std::vector<std::string> names;
  for (const MarkerDictionaryInfo& row : kMarkerDictionaries) names.emplace_back(row.name);
  const MarkerDictionaryInfo& dictionary =
      kMarkerDictionaries[f.choice("dictionary", names, std::size_t(map.dictionary))];
  map.dictionary = dictionary.dictionary;

  for (const auto& [name, sigma] :
       {std::pair("position_sigma", &map.position_sigma), std::pair("angle_sigma", &map.angle_sigma)}) {
    auto maybe_sigma = *sigma == 0 ? std::nullopt : std::optional(*sigma);
    f.optional(name, maybe_sigma);
    *sigma = maybe_sigma.value_or(0);
    f.check(*sigma >= 0, name, "it is negative", "give one standard deviation, or leave it out");
  }

  f.list("markers", "marker", map.markers);
  f.check(!map.markers.empty(), "markers", "there is none", "list at least one marker");
  std::set<int> ids;
  for (const PlacedMarker& marker : map.markers) {
    const std::string id = std::to_string(marker.id);
    f.check(ids.insert(marker.id).second, "markers", "marker " + id + " is listed twice",
            "list every marker once");
    f.check(marker.id >= 0 && marker.id < dictionary.count, "markers",
            std::string(dictionary.name) + " has no marker " + id,
            "give an id from 0 to " + std::to_string(dictionary.count - 1));
  }
}

MarkerMap load_marker_map(const std::filesystem::path& path) {
  return load_noun<MarkerMap>(path, Syntax::kJson);
}

void save_marker_map(const std::filesystem::path& path, const MarkerMap& map) {
  save_noun(path, Syntax::kJson, map);
}

MarkerMap parse_marker(const std::string& text) {
  const auto wrong = [&](const std::string& why) {
    return Error(ErrorKind::kInput, "marker '" + text + "'", why,
                 "write DICTIONARY:ID:SIZE, e.g. apriltag_36h11:3:160mm");
  };
  const std::size_t first = text.find(':'), second = text.find(':', first + 1);
  if (first == std::string::npos || second == std::string::npos) throw wrong("it does not have three parts");
  try {
    const auto named = marker_dictionary_named(text.substr(0, first));
    if (!named) {
      std::string known;
      for (const MarkerDictionaryInfo& row : kMarkerDictionaries)
        known += (known.empty() ? "" : ", ") + std::string(row.name);
      throw wrong("its dictionary is none of " + known);
    }
    const MarkerDictionaryInfo& dictionary = info_of(*named);
    PlacedMarker marker;
    const char* const end = text.data() + second;
    const auto [stop, error] = std::from_chars(text.data() + first + 1, end, marker.id);
    if (error != std::errc() || stop != end) throw wrong("its id is no number");
    if (marker.id < 0 || marker.id >= dictionary.count)
      throw wrong(std::string(dictionary.name) + " has the ids 0 to " + std::to_string(dictionary.count - 1));
    marker.size = parse_length(text.substr(second + 1));
    if (!(marker.size > 0)) throw wrong("its size is not positive");
    MarkerMap map;
    map.dictionary = dictionary.dictionary;
    map.markers = {marker};
    return map;
  } catch (const Error& error) {
    if (error.subject().rfind("length", 0) == 0) throw wrong("its size is no length: " + error.why());
    throw;
  }
}

}  // namespace procam::io
