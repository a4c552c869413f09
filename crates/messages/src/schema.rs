//! ROS 2 message definitions with all that they depend on, as rosbag2 writes them.

/// Schema encoding of the texts in this module, as an MCAP schema record names it.
pub const SCHEMA_ENCODING: &str = "ros2msg";

/// Between a definition and the next: a line of 80 equals signs and the type's name.
macro_rules! part {
    ($name:literal, $fields:expr) => {
        concat!(
            "================================================================================\nMSG: ",
            $name,
            "\n",
            $fields
        )
    };
}

macro_rules! header {
    () => {
        concat!(
            part!("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
            part!("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n")
        )
    };
}

macro_rules! vector3 {
    () => {
        part!("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n")
    };
}

macro_rules! quaternion {
    () => {
        part!("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n")
    };
}

/// `sensor_msgs/msg/LaserScan`.
pub const LASER_SCAN: &str = concat!(
    "std_msgs/Header header\n",
    "float32 angle_min\n",
    "float32 angle_max\n",
    "float32 angle_increment\n",
    "float32 time_increment\n",
    "float32 scan_time\n",
    "float32 range_min\n",
    "float32 range_max\n",
    "float32[] ranges\n",
    "float32[] intensities\n",
    header!()
);

/// `sensor_msgs/msg/MultiEchoLaserScan`.
pub const MULTI_ECHO_LASER_SCAN: &str = concat!(
    "std_msgs/Header header\n",
    "float32 angle_min\n",
    "float32 angle_max\n",
    "float32 angle_increment\n",
    "float32 time_increment\n",
    "float32 scan_time\n",
    "float32 range_min\n",
    "float32 range_max\n",
    "sensor_msgs/LaserEcho[] ranges\n",
    "sensor_msgs/LaserEcho[] intensities\n",
    header!(),
    part!("sensor_msgs/LaserEcho", "float32[] echoes\n")
);

/// `sensor_msgs/msg/PointCloud2`.
pub const POINT_CLOUD2: &str = concat!(
    "std_msgs/Header header\n",
    "uint32 height\n",
    "uint32 width\n",
    "sensor_msgs/PointField[] fields\n",
    "bool is_bigendian\n",
    "uint32 point_step\n",
    "uint32 row_step\n",
    "uint8[] data\n",
    "bool is_dense\n",
    header!(),
    part!("sensor_msgs/PointField", "string name\nuint32 offset\nuint8 datatype\nuint32 count\n")
);

/// `nav_msgs/msg/Odometry`.
pub const ODOMETRY: &str = concat!(
    "std_msgs/Header header\n",
    "string child_frame_id\n",
    "geometry_msgs/PoseWithCovariance pose\n",
    "geometry_msgs/TwistWithCovariance twist\n",
    header!(),
    part!("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    part!("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    part!("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    quaternion!(),
    part!("geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"),
    part!("geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"),
    vector3!()
);

/// `tf2_msgs/msg/TFMessage`.
pub const TF_MESSAGE: &str = concat!(
    "geometry_msgs/TransformStamped[] transforms\n",
    part!(
        "geometry_msgs/TransformStamped",
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"
    ),
    header!(),
    part!("geometry_msgs/Transform", "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"),
    vector3!(),
    quaternion!()
);
