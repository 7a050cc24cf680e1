// What is the same for every pixel of the comparison. The vertex shader hands it on: a software renderer fetches a
// uniform once for each pixel, but a flat input once for each triangle. In the order of `Parameters` in
// server/compare/compare_parameters.h. PARAMETER is `flat out` or `flat in`.
PARAMETER vec4 intrinsics;     // fx, fy, cx, cy
PARAMETER vec4 sensor_axial;   // SensorNoise: coefficients of the sigma by depth (3); 1 where a mean of frames was measured
PARAMETER vec4 sensor_shape;   // range (2), 1 where it grows at grazing views, step
PARAMETER vec4 sensor_lateral; // lateral sigma, its growth, its least; largest reach in pixels
PARAMETER vec4 threshold_by;   // fixed threshold in metres (0: by sigma), sigmas, variance of the model, largest threshold
// Covariance of the pose's twist (v, w): diagonals of the blocks, what is beside them as (yz, zx, xy), and the columns of
// the block between v and w.
PARAMETER vec3 variance_v;
PARAMETER vec3 covariance_vv;
PARAMETER vec3 variance_w;
PARAMETER vec3 covariance_ww;
PARAMETER vec3 covariance_v_wx;
PARAMETER vec3 covariance_v_wy;
PARAMETER vec3 covariance_v_wz;
// Covariance of the intrinsics.
PARAMETER vec4 variance_intrinsics;
PARAMETER vec3 covariance_fx;  // with fy, cx, cy
PARAMETER vec3 covariance_fy;  // with cx, cy; of cx with cy
