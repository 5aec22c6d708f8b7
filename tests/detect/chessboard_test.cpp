#include "procam/detect/chessboard.hpp"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <cstdio>
#include "rendered_board.hpp"

namespace procam {
namespace {
using test::BoardScene;

TEST(X, Explore) {
  for (double blur : {0.9}) for (double noise : {0.5}) for (double share : {0.35}) {
    double se[3] = {0, 0, 0}, chi = 0, mx = 0, sig = 0; Vec2 bias(0, 0); int n = 0;
    for (int k = 0; k < 3; ++k) {
      BoardScene scene;
      scene.blur_px = blur; scene.noise = noise; scene.seed = 10 + k;
      scene.camera_from_board = scene.facing(Vec3(0.31 - 0.4 * k, -0.42 + 0.3 * k, 0.13 + 0.2 * k),Vec3(0.02,-0.015,1.5+0.1*k));
      const ImageU8 image = test::render(scene);
      const Points2 truth = test::true_corners(scene);
      detect::ChessboardOptions o; o.window_share = share;
      const Detections d = detect::detect_chessboard(image, scene.board, o);
      for (auto& i : d.diagnostics.items) printf("%s %s\n", i.code.c_str(), i.message.c_str());
      cv::Mat m(image.height(), image.width(), CV_8U, (void*)image.data());
      for (auto& ob : d.observations) {
        // order may be half-turned
        Vec2 e = ob.pixel - truth[ob.point]; if (e.norm() > 5) e = ob.pixel - truth[62 - ob.point];
        se[0] += e.squaredNorm(); chi += e.dot(ob.covariance.inverse() * e); mx = std::max(mx, e.norm()); bias += e; sig += ob.covariance.trace();
        ++n;
      }
      std::vector<cv::Point2f> q;
      cv::findChessboardCornersSB(m, cv::Size(7, 9), q, cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY);
      auto near = [&](cv::Point2f c) { double b = 1e9; for (auto& t : truth) b = std::min(b, (t - Vec2(c.x, c.y)).squaredNorm()); return b; };
      for (auto& c : q) se[1] += near(c);
      cv::cornerSubPix(m, q, cv::Size(5, 5), cv::Size(-1, -1), cv::TermCriteria(3, 100, 1e-4));
      for (auto& c : q) se[2] += near(c);
    }
    printf("blur %.1f noise %.1f share %.2f n %d rms own %.4f (max %.3f, chi2/2 %.2f bias %.4f %.4f sigma %.4f)  SB %.4f subpix %.4f\n", blur, noise, share, n, std::sqrt(se[0] / 2/ n), mx, chi / (2 * n), bias.x() / n, bias.y() / n, std::sqrt(sig/2/n), std::sqrt(se[1] / 2/ n), std::sqrt(se[2] / 2/ n));
  }
}
}  // namespace
}  // namespace procam
