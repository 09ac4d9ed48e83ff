// Cooperative matrices of 16 × 16: f16 operands, products accumulated in f32.

enable f16;
enable wgpu_cooperative_matrix;

const EDGE = 16u;

alias Weights = coop_mat16x16<f16, A>;
alias Pixels = coop_mat16x16<f16, B>;
alias Sums = coop_mat16x16<f32, C>;

