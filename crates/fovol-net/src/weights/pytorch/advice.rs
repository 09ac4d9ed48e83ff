/// Advice for a file that holds something else.
pub const SAVE: &str = "save only the tensors, with torch.save(network.state_dict(), \"FILE.pt\")";
