// Cooperative matrices of 8 × 8: f16 operands, products accumulated in f32.

enable f16;
enable wgpu_cooperative_matrix;

const EDGE = 8u;

alias Weights = coop_mat8x8<f16, A>;
alias Pixels = coop_mat8x8<f16, B>;
alias Sums = coop_mat8x8<f32, C>;

