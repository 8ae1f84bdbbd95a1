//! Nothing. The build scripts of iceoryx2 call bindgen on QNX only; on Linux, where runs are possible, it would take eleven packages
//! and a part of the first build to compile it for nothing.
