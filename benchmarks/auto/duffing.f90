subroutine func(ndim,u,icp,par,ijac,f,dfdu,dfdp)
  implicit none
  integer, intent(in) :: ndim, icp(*), ijac
  double precision, intent(in) :: u(ndim), par(*)
  double precision, intent(out) :: f(ndim)
  double precision, intent(inout) :: dfdu(ndim,ndim), dfdp(ndim,*)
  double precision x,v,c,s,w,r
  x=u(1); v=u(2); c=u(3); s=u(4); w=par(1); r=1d0-c*c-s*s
  f(1)=v
  f(2)=c-0.1d0*v-x-0.05d0*x*x*x
  f(3)=c*r-w*s
  f(4)=s*r+w*c
  if (ijac==0) return
  dfdu=0d0
  dfdu(1,2)=1d0
  dfdu(2,1)=-1d0-0.15d0*x*x; dfdu(2,2)=-0.1d0; dfdu(2,3)=1d0
  dfdu(3,3)=r-2d0*c*c; dfdu(3,4)=-2d0*c*s-w
  dfdu(4,3)=-2d0*c*s+w; dfdu(4,4)=r-2d0*s*s
  if (ijac==1) return
  dfdp(1,1)=0d0; dfdp(2,1)=0d0; dfdp(3,1)=-s; dfdp(4,1)=c
end subroutine
subroutine stpnt(ndim,u,par,t)
  implicit none
  integer, intent(in) :: ndim
  double precision, intent(inout) :: u(ndim),par(*)
  double precision, intent(in) :: t
  double precision w,a,b,d,pi,p
  pi=4d0*atan(1d0); w=3d0; par(1)=w; par(11)=2d0*pi/w; p=2d0*pi*t
  d=(1d0-w*w)**2+(0.1d0*w)**2; a=(1d0-w*w)/d; b=0.1d0*w/d
  u(1)=a*cos(p)+b*sin(p); u(2)=w*(-a*sin(p)+b*cos(p)); u(3)=cos(p); u(4)=sin(p)
end subroutine
subroutine bcnd
end subroutine
subroutine icnd
end subroutine
subroutine fopt
end subroutine
subroutine pvls
end subroutine
