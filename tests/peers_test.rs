//! Other engines run the standard cases beside ours.

mod peers;
