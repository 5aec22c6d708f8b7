#include "condition_settings.hpp"

#include <functional>

#include "procam/core/base/error.hpp"
#include "procam/io/text.hpp"
#include "procam/session/simulated.hpp"

namespace procam::session {
namespace {

using simulate::Conditions;
using simulate::Range;

struct ConditionSetting {
  const char* key;
  const char* example;
  const char* help;
  std::function<void(Conditions&, const std::string&)> apply;
};

Range always(double value) {
  return {value, value};
}

int parse_count(const std::string& text) {
  const double value = io::parse_share(text);
  if (!(value >= 0 && value <= 1000 && value == double(int(value))))
    throw Error(ErrorKind::kInput, "'" + text + "'", "it is not a number of views",
                "write a number such as 2");
  return int(value);
}

/// An RMS of 0 to `largest`; NaN is none.
double within(double value, double largest, const std::string& text, const std::string& why,
              const std::string& example) {
  if (!(value >= 0 && value <= largest))
    throw Error(ErrorKind::kInput, "'" + text + "'", why, "write one such as " + example);
  return value;
}

double parse_rms(const std::string& text) {
  return within(io::parse_pixels(text), 10, text, "it is not a displacement of 0 to 10 px (RMS)", "0.05px");
}

double parse_refocus(const std::string& text) {
  return within(io::parse_share(text), 0.05, text, "it is not a change of the focal length of 0 to 5 % (RMS)",
                "0.3%");
}

double parse_displacement(const std::string& text) {
  return within(io::parse_pixels(text), 100, text, "it is not a displacement of 0 to 100 px (RMS)", "2px");
}

double parse_rise(const std::string& text) {
  return within(io::parse_length(text), 0.1, text, "it is not a rise of 0 to 100 mm (RMS)", "1mm");
}

const std::vector<ConditionSetting>& settings_table() {
  static const std::vector<ConditionSetting> table{
      {"skew", "3px", "skew of camera and projector, K(0,1)",
       [](Conditions& c, const std::string& text) {
         c.camera_skew_px = c.projector_skew_px = always(io::parse_pixels(text));
       }},
      {"camera-skew", "3px", "of the camera alone",
       [](Conditions& c, const std::string& text) { c.camera_skew_px = always(io::parse_pixels(text)); }},
      {"projector-skew", "3px", "of the projector alone",
       [](Conditions& c, const std::string& text) { c.projector_skew_px = always(io::parse_pixels(text)); }},
      {"k3", "0.02", "sixth-order radial distortion of camera and projector",
       [](Conditions& c, const std::string& text) {
         c.camera_k3 = c.projector_k3 = always(io::parse_share(text));
       }},
      {"camera-k3", "0.02", "of the camera alone",
       [](Conditions& c, const std::string& text) { c.camera_k3 = always(io::parse_share(text)); }},
      {"projector-k3", "0.02", "of the projector alone",
       [](Conditions& c, const std::string& text) { c.projector_k3 = always(io::parse_share(text)); }},
      {"lens-deviation", "0.05px",
       "smooth displacement of the pictures of camera and projector that no lens model has, RMS; of boards",
       [](Conditions& c, const std::string& text) {
         c.camera_deviation_px = c.projector_deviation_px = parse_rms(text);
       }},
      {"camera-lens-deviation", "0.05px", "of the camera alone",
       [](Conditions& c, const std::string& text) { c.camera_deviation_px = parse_rms(text); }},
      {"projector-lens-deviation", "0.05px", "of the projector alone",
       [](Conditions& c, const std::string& text) { c.projector_deviation_px = parse_rms(text); }},
      {"gamma", "2.2", "of the camera; 1: linear",
       [](Conditions& c, const std::string& text) { c.gamma = always(io::parse_share(text)); }},
      {"colour-sensor", "1", "1: a sensor with colour filters, whose colours are interpolated; 0: a grey one",
       [](Conditions& c, const std::string& text) { c.colour_sensor = parse_count(text) > 0; }},
      {"lateral-colour", "0.05%", "share by which a colour sensor sees blue larger than green",
       [](Conditions& c, const std::string& text) { c.lateral_colour = io::parse_share(text); }},
      {"projector-gamma", "2.2", "of the projector; 1: linear",
       [](Conditions& c, const std::string& text) { c.projector_gamma = io::parse_share(text); }},
      {"iris", "50%", "power of the frame's mean that the projector's lamp follows (dynamic contrast)",
       [](Conditions& c, const std::string& text) { c.iris = io::parse_share(text); }},
      {"noise", "2", "factor on the sensor's noise; 0: none",
       [](Conditions& c, const std::string& text) { c.noise_factor = io::parse_share(text); }},
      {"vignetting", "4", "power of the cosine of the field angle",
       [](Conditions& c, const std::string& text) { c.vignetting = io::parse_share(text); }},
      {"indirect", "10%", "light that surfaces reflect onto each other",
       [](Conditions& c, const std::string& text) { c.indirect = io::parse_share(text); }},
      {"glare", "4%", "light that the camera's lens scatters over its image",
       [](Conditions& c, const std::string& text) { c.glare = io::parse_share(text); }},
      {"contrast", "20%",
       "of projected stripes of two pixels where the projector is most out of focus; 100%: in focus",
       [](Conditions& c, const std::string& text) { c.finest_contrast = io::parse_share(text); }},
      {"dark-views", "2", "number of underexposed views",
       [](Conditions& c, const std::string& text) { c.dark_views = parse_count(text); }},
      {"white", "25%", "their white paper, share of full scale in linear light",
       [](Conditions& c, const std::string& text) { c.white = always(io::parse_share(text)); }},
      {"overexposed-views", "1", "number of overexposed views",
       [](Conditions& c, const std::string& text) { c.overexposed_views = parse_count(text); }},
      {"overexposure", "160%", "their white paper",
       [](Conditions& c, const std::string& text) { c.overexposure = io::parse_share(text); }},
      {"moved-views", "1", "number of views in which the board moves during the sequence",
       [](Conditions& c, const std::string& text) { c.moved_views = parse_count(text); }},
      {"moved", "8mm", "by this distance",
       [](Conditions& c, const std::string& text) { c.moved_by = always(io::parse_length(text)); }},
      {"stale-views", "1", "number of views in which one capture shows the frame before",
       [](Conditions& c, const std::string& text) { c.stale_views = parse_count(text); }},
      {"missing-views", "1",
       "number of views in which a frame is missing, so that all later captures show the next",
       [](Conditions& c, const std::string& text) { c.missing_views = parse_count(text); }},
      {"torn-views", "1", "number of views in which a capture shows the next frame in its lower rows",
       [](Conditions& c, const std::string& text) { c.torn_views = parse_count(text); }},
      {"auto-exposure", "30%", "power of the image's mean that the exposure follows",
       [](Conditions& c, const std::string& text) { c.auto_exposure = io::parse_share(text); }},
      {"flicker", "6%", "amplitude of brightness over rows and frames",
       [](Conditions& c, const std::string& text) { c.flicker = io::parse_share(text); }},
      {"shake", "1px", "sigma of each capture's shift",
       [](Conditions& c, const std::string& text) { c.shake_px = io::parse_pixels(text); }},
      {"drift", "4px", "of the camera's image over the sequence",
       [](Conditions& c, const std::string& text) { c.drift_px = io::parse_pixels(text); }},
      {"projector-drift", "3px", "of the projected frame over the sequence",
       [](Conditions& c, const std::string& text) { c.projector_drift_px = io::parse_pixels(text); }},
      {"focus-drift", "2px", "blur of the camera at the start of the sequence, none at its end",
       [](Conditions& c, const std::string& text) { c.focus_drift_px = io::parse_pixels(text); }},
      {"lag", "20%", "share of the frame before that each capture still shows",
       [](Conditions& c, const std::string& text) { c.lag = io::parse_share(text); }},
      {"spot", "3", "reflection of a lamp on the board, multiple of full scale",
       [](Conditions& c, const std::string& text) { c.spot = io::parse_share(text); }},
      {"bend", "6mm", "rise of the sheet half a metre from the print's middle, like a cylinder; 0mm: flat",
       [](Conditions& c, const std::string& text) { c.bend = always(io::parse_length(text)); }},
      {"flex", "1mm", "RMS of the rise that the sheet has anew in each view, as bend",
       [](Conditions& c, const std::string& text) { c.flex = parse_rise(text); }},
      {"refocus", "0.3%", "RMS of the change of the camera's focal length anew in each view (autofocus)",
       [](Conditions& c, const std::string& text) { c.refocus = parse_refocus(text); }},
      {"stabiliser", "2px", "RMS of the displacement of the camera's image anew in each view",
       [](Conditions& c, const std::string& text) { c.stabiliser_px = parse_displacement(text); }},
      {"print-scale", "98%", "true size of the print / size that session.json states",
       [](Conditions& c, const std::string& text) { c.print_scale = io::parse_share(text); }},
  };
  return table;
}

}  // namespace

std::string settings_help() {
  std::string help = "plain (every effect off)";
  for (const ConditionSetting& setting : settings_table())
    help += std::string(", ") + setting.key + "=" + setting.example + " (" + setting.help + ")";
  return help;
}

Conditions with_settings(Conditions conditions, const std::vector<std::string>& settings) {
  for (const std::string& text : settings) {
    if (text == "plain") {
      conditions = simulate::plain_conditions();
      continue;
    }
    const std::size_t equal = text.find('=');
    const std::string key = text.substr(0, equal);
    std::vector<std::string> known{"plain"};
    const ConditionSetting* found = nullptr;
    for (const ConditionSetting& setting : settings_table()) {
      known.push_back(setting.key);
      if (key == setting.key) found = &setting;
    }
    if (found == nullptr)
      throw Error(ErrorKind::kInput, "setting '" + text + "'", "there is no key '" + key + "'",
                  io::suggest(key, known));
    if (equal == std::string::npos)
      throw Error(ErrorKind::kInput, "setting '" + text + "'", "it has no value",
                  std::string("write ") + found->key + "=" + found->example);
    found->apply(conditions, text.substr(equal + 1));
  }
  return conditions;
}

}  // namespace procam::session
